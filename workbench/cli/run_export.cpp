// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>

#include "workbench/base/text.h"
#include "workbench/c_export/friction_header.h"
#include "workbench/cli/commands.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {
namespace {

/// The begin of names of C: a letter, then letters, digits and _.
void check_name(const std::string& name) {
  constexpr std::size_t kLongest = 40;
  const auto is_letter = [](unsigned char c) { return c < 0x80 && std::isalpha(c) != 0; };
  const bool fits = is_letter(static_cast<unsigned char>(name[0])) && name.size() <= kLongest &&
                    std::all_of(name.begin(), name.end(), [&](unsigned char c) {
                      return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
                    });
  if (fits) return;
  throw UsageError(fmt::format("--name {}: give a letter, then letters, digits and _, at most {} in all",
                               in_quotes(name), kLongest));
}

}  // namespace

void run_export(const Options& options) {
  check_name(options.name);
  FrictionHeaderOptions header;
  header.is_float = options.scalar == "float";
  header.name = options.name;
  if (options.step_m > 0.0) header.step_m = options.step_m;
  if (options.rate_Hz > 0.0) header.rate_Hz = options.rate_Hz;
  if (header.step_m && !header.is_float)
    throw UsageError("--step: only of --scalar float; in double there is one position, and no steps");
  Outputs outputs;
  outputs.protect_input(options.model);
  outputs.claim(options.c_header);
  const Model model = read_model(options.model);
  try {
    outputs.set(options.c_header, friction_header(model, header));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", printable(options.model), error.what()));
  }
  outputs.commit(fmt::format("{}: model {:08x} in C99, {}_init() and {}_step()\n",
                             printable(options.c_header), target_hash(model), header.name, header.name));
}

}  // namespace slipstack::workbench
