// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/console/output.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/expression/to_cpp.h"
#include "workbench/report/effect_page.h"

namespace slipstack::workbench {

namespace {

/// The header of the one effect that --effect defines.
std::string header_text(const Options& options) {
  if (options.user_effects.size() != 1) throw UsageError("--header: define one effect by --effect");
  const EffectDescription& effect = *declare_effects(options.user_effects).front();
  const Definition definition = parse_definition(effect.definition);
  return to_effect_header(definition, roles_of(definition));
}

}  // namespace

void run_effects(const Options& options) {
  Outputs outputs;
  std::string text;
  if (!options.header.empty()) {
    outputs.claim(options.header);
    outputs.set(options.header, header_text(options));
    text = fmt::format(
        "{}: put it into firmware/effects and its class into firmware/effects/catalogue.h "
        "(docs/adding-an-effect.md)\n",
        printable(options.header));
  } else if (!options.pages.empty()) {
    const std::filesystem::path folder = options.pages;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
      throw UsageError(fmt::format("{}: cannot be made: {}; name a folder that can be written",
                                   printable(options.pages), error.message()));
    }
    const auto put = [&](const std::string& name, std::string page) {
      const std::string path = (folder / name).string();
      outputs.claim(path);
      outputs.set(path, std::move(page));
    };
    put("README.md", effect_index());
    for (const EffectDescription& effect : catalogue()) put(effect.id() + ".md", effect_page(effect));
    text = fmt::format("{} pages in {}\n", catalogue().size() + 1, printable(options.pages));
  } else if (!options.effect.empty()) {
    text = effect_description(effect_named(options.effect));
  } else {
    text = effect_lines("") + "`slipstack effects ID` describes one in full.\n";
  }
  outputs.commit(text);
}

}  // namespace slipstack::workbench
