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
};

/// Does the work of a command with a progress line, prints its result on standard output and writes the
/// requested files, all or none. Throws UsageError and InputError (exit status 2).
void run_command(const std::function<CommandResult(Outputs& outputs, Progress& progress)>& work);

/// `slipstack effects`, as above.
void run_effects(const Options& options);

}  // namespace slipstack::workbench
