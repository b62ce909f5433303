// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/papers/result.h"

namespace slipstack::workbench {

/// What every experiment writes.
struct ExperimentOutputs {
  std::string report;
  std::string json;
  std::string out = "";  ///< a file of the experiment's own kind
};

/// Adds --report and --json.
void add_experiment_outputs(CLI::App& command, ExperimentOutputs& outputs);
/// An option with a text that must not be empty.
CLI::Option* add_word(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description);

/// Runs `work` under a progress line and writes what it returns: tables on standard output, JSON and report
/// where asked for, all or none. `inputs` are files that no output may replace. A SetupError or
/// std::invalid_argument of the plant becomes a UsageError: one line, status 2.
void deliver(const std::string& command_line, const ExperimentOutputs& outputs,
             const std::vector<std::string>& inputs, const std::function<ExperimentResult(Progress&)>& work);

/// Runs `work`; what the plant refuses becomes one line that begins with `where`, status 2.
void said_of(const std::string& where, const std::function<void()>& work);

// Each experiment: one file of this folder, one line in define_experiment().
void define_describing_function(CLI::App& experiment, const std::string& command_line);
void define_free(CLI::App& experiment, const std::string& command_line);
void define_characterize(CLI::App& experiment, const std::string& command_line);
void define_guideway(CLI::App& experiment, const std::string& command_line);
void define_transducer(CLI::App& experiment, const std::string& command_line);
void define_loops(CLI::App& experiment, const std::string& command_line);
void define_sensitivity(CLI::App& experiment, const std::string& command_line);
void define_step(CLI::App& experiment, const std::string& command_line);
void define_stepped_sine(CLI::App& experiment, const std::string& command_line);
void define_models(CLI::App& experiment, const std::string& command_line);

}  // namespace slipstack::workbench
