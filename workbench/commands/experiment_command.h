// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/commands/command.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// The work of a command whose result is that of an experiment; its files are claimed before and set after
/// it. `inputs`: files that no output may replace. A std::invalid_argument of the analysis becomes a
/// UsageError.
CommandResult execute_experiment(const ExperimentOutputs& wanted, const std::vector<std::string>& inputs,
                                 const std::string& command_line, Outputs& outputs,
                                 const std::function<ExperimentResult()>& work);

}  // namespace slipstack::workbench
