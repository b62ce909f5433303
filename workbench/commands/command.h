// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/log/csv/raw_table.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/plan/known_axis.h"
#include "workbench/report/results/experiment_outputs.h"

// The commands on logs and models, from their options to what they write: the command line and the Python
// module call the same.
namespace slipstack::workbench {

/// The options of a command; empty strings where an option was not given.
struct CommandOptions {
  ProcessGroup* group = nullptr;  ///< processes that share the work
  std::string command_line;       ///< as the user typed it, for the report
  std::vector<std::string> logs;  ///< paths, or the names of those in memory
  LogsInMemory in_memory;         ///< those of `logs` that are no files
  std::string per_log;   ///< ids of effects whose gains differ from log to log; "none"; empty: the default
  double noise_N = 0.0;  ///< standard deviation of the force's noise before the filter; 0: estimated
  std::string model;     ///< read by compare, diagnose and add; written by fit
  std::optional<std::string> model_content;  ///< where the model that is read is no file
  std::string effects;                       ///< ids separated by commas
  std::string effect;
  std::vector<std::string> user_effects;  ///< definitions of user-defined effects
  std::string out;
  std::string report;
  std::string json;
  std::string criterion;   ///< of fit: "force" (inverse dynamics) or "simulation"
  double horizon_s = 0.0;  ///< of the runs of the latter
  bool stepwise = false;
};

/// What a command found, in the forms in which it is given out.
struct CommandResult {
  std::string text;  ///< of the terminal
  std::string json;  ///< as --json writes it
  std::string file;  ///< of fit and add the model, of plan and simulate the CSV of --out; else empty
};

/// Each does the work of a command, with the files that the options name claimed before and set after it in
/// `outputs`, which the caller commits. Throw UsageError, InputError and DefinitionError; Cancelled.
CommandResult execute_compare(const CommandOptions& options, Outputs& outputs, Progress& progress);
CommandResult execute_fit(const CommandOptions& options, Outputs& outputs, Progress& progress);
CommandResult execute_diagnose(const CommandOptions& options, Outputs& outputs, Progress& progress);
CommandResult execute_add(const CommandOptions& options, Outputs& outputs, Progress& progress);

/// The work of `slipstack experiment plan`, as above.
CommandResult execute_plan(const PlanRequest& request, const ExperimentOutputs& wanted,
                           const std::string& command_line, Outputs& outputs, Progress& progress);

/// What `slipstack simulate` was asked for: a model, and a log or set points.
struct SimulateRequest {
  std::string model;
  std::optional<std::string> model_content;  ///< where `model` is no file
  std::string log;
  LogsInMemory in_memory;  ///< `log`, where it is no file
  std::string set_points;
  std::optional<RawTable> points;  ///< where `set_points` is no file: time_s, position_m, as a file has them
  double start_s = 0.0;
  double end_s = 0.0;  ///< 0: the end of the log
};

/// Its work, as above.
CommandResult execute_simulate(const SimulateRequest& request, const ExperimentOutputs& wanted,
                               const std::string& command_line, Outputs& outputs, Progress& progress);

/// Status of the program where the input or its use is to blame, and where a fault of ours is.
inline constexpr int kUnusableInput = 2;
inline constexpr int kInternalFault = 1;

/// A message without its last newlines, control characters escaped: safe for a terminal.
std::string as_one_line(std::string_view message);

/// An exception of a command as it is told to the user.
struct ErrorReport {
  std::string line;     ///< as_one_line()
  std::string picture;  ///< of a wrong definition: the text and a caret under the fault; else empty
  int status = kInternalFault;
};
ErrorReport error_report_of(const std::exception_ptr& fault);

}  // namespace slipstack::workbench
