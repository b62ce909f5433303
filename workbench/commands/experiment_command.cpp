// SPDX-License-Identifier: Apache-2.0
#include "workbench/commands/experiment_command.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "workbench/base/errors.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {

CommandResult execute_experiment(const ExperimentOutputs& wanted, const std::vector<std::string>& inputs,
                                 const std::string& command_line, Outputs& outputs,
                                 const std::function<ExperimentResult()>& work) {
  claim_outputs(wanted, inputs, outputs);
  ExperimentResult result;
  try {
    result = work();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  set_outputs(wanted, result, command_line, outputs);
  return {result_text(result), json_text(result_json(result)), result.file};
}

}  // namespace slipstack::workbench
