// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/define_manual.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim_host/cli/define_sim.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/console/output.h"
#include "workbench/manual/command_text.h"
#include "workbench/manual/completion.h"
#include "workbench/manual/man_page.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {
namespace {

struct ManualRequest {
  std::string shell;
  std::string program = "slipstack";
  std::string folder;
};

/// slipstack-sim has a program of its own; its options are defined apart from it.
CommandText simulator_text() {
  CLI::App app;
  sim::LogRequest request;
  sim::define_sim(app, request);
  return command_text(app, "slipstack-sim");
}

std::vector<std::string> effect_ids() {
  std::vector<std::string> ids;
  for (const EffectDescription& effect : catalogue()) ids.push_back(effect.id());
  return ids;
}

void print_completion(const CLI::App& app, const ManualRequest& request) {
  const CommandText program =
      request.program == "slipstack" ? command_text(app, "slipstack") : simulator_text();
  Outputs().commit(request.shell == "bash" ? bash_completion(program, effect_ids())
                                           : zsh_completion(program, effect_ids()));
}

void write_manual(const CLI::App& app, const std::string& name) {
  const std::filesystem::path folder = name;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw UsageError(fmt::format("{}: cannot be made: {}; name a folder that can be written", printable(name),
                                 error.message()));
  }
  const std::string version = "slipstack " SLIPSTACK_VERSION;
  auto pages = man_pages(command_text(app, "slipstack"), version);
  for (auto& page : man_pages(simulator_text(), version)) pages.push_back(std::move(page));
  Outputs outputs;
  for (auto& [file, page] : pages) {
    const std::string path = (folder / file).string();
    outputs.claim(path);
    outputs.set(path, std::move(page));
  }
  outputs.commit(fmt::format("{} pages in {}\n", pages.size(), printable(name)));
}

}  // namespace

void define_manual(CLI::App& app) {
  const auto request = std::make_shared<ManualRequest>();
  CLI::App* completion =
      app.add_subcommand("completion", "Print the completion of the command line for a shell");
  completion->add_option("SHELL", request->shell, "bash or zsh, as in: . <(slipstack completion bash)")
      ->check(CLI::IsMember({"bash", "zsh"}))
      ->type_name("SHELL")
      ->required();
  completion->add_option("--program", request->program, "whose command line")
      ->check(CLI::IsMember({"slipstack", "slipstack-sim"}))
      ->type_name("NAME")
      ->capture_default_str();
  completion->callback([&app, request] { print_completion(app, *request); });

  CLI::App* manual = app.add_subcommand("manual", "Write the man pages, one for each command");
  manual->add_option("FOLDER", request->folder, "folder to write them to")
      ->check([](const std::string& text) { return text.empty() ? "must not be empty" : ""; })
      ->type_name("FOLDER")
      ->required();
  manual->callback([&app, request] { write_manual(app, request->folder); });
}

}  // namespace slipstack::workbench
