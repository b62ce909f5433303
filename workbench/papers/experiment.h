// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/console/progress.h"
#include "workbench/log/log.h"
#include "workbench/report/results/experiment_outputs.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// Runs `work` with a progress line and writes its result: tables on standard output, JSON and report where
/// asked for, all or none. `inputs` are files that no output may replace. A SetupError or
/// std::invalid_argument of the simulation or the analysis becomes a UsageError: one line, status 2.
void run_experiment(const std::string& command_line, const ExperimentOutputs& outputs,
                    const std::vector<std::string>& inputs,
                    const std::function<ExperimentResult(Progress&)>& work);

/// Reads a log of a guideway. Throws InputError where the log is of a rotary axis.
Log read_guideway_log(const std::string& path);

/// Runs `work`; a std::invalid_argument becomes an InputError whose line begins with `source`, status 2.
void prefix_errors(const std::string& source, const std::function<void()>& work);

}  // namespace slipstack::workbench
