// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "workbench/commands/command.h"

namespace slipstack::workbench {

/// The options of the command line; empty strings where an option was not given.
struct Options : CommandOptions {
  std::string pages;  ///< of effects: folder
  std::string header;
  std::string c_header;  ///< of export
  std::string scalar;    ///< "float" or "double"
  std::string name;      ///< begin of the names in it
  double step_m = 0.0;   ///< unit of its displacement; 0: not given
  double rate_Hz = 0.0;  ///< of its ticks; 0: not given
};

/// Does the work of a command with a progress line, prints its result on standard output and writes the
/// requested files, all or none. Throws UsageError and InputError (exit status 2).
void run_command(const std::function<CommandResult(Outputs& outputs, Progress& progress)>& work);

/// `slipstack effects` and `slipstack export`, as above.
void run_effects(const Options& options);
void run_export(const Options& options);

}  // namespace slipstack::workbench
