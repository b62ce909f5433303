// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/plan_motion.h"
#include "workbench/commands/experiment_command.h"

namespace slipstack::workbench {

CommandResult execute_plan(const PlanRequest& request, const ExperimentOutputs& wanted,
                           const std::string& command_line, Outputs& outputs, Progress& progress) {
  check_plan(request);
  std::vector<std::string> inputs;
  for (const std::string& log : request.logs) {
    if (!request.in_memory.contains(log)) inputs.push_back(log);
  }
  if (!request.model_content) inputs.push_back(request.model);
  return execute_experiment(wanted, inputs, command_line, outputs,
                            [&] { return plan_motion(request, progress); });
}

}  // namespace slipstack::workbench
