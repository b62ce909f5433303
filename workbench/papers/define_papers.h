// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/papers/experiment.h"

namespace CLI {  // NOLINT(readability-identifier-naming): the name is CLI11's
class App;
class Option;
}  // namespace CLI

namespace slipstack::workbench {

/// Adds the experiments of the papers to `slipstack experiment`. `command_line` is read when a command runs.
void define_experiments_of_papers(CLI::App& experiment, const std::string& command_line);

/// Adds --report and --json.
void add_experiment_outputs(CLI::App& command, ExperimentOutputs& outputs);
/// An option with a text that must not be empty.
CLI::Option* add_word(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description);

}  // namespace slipstack::workbench
