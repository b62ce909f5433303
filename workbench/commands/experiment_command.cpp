// SPDX-License-Identifier: Apache-2.0
#include "workbench/commands/experiment_command.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {

CommandResult execute_experiment(const ExperimentOutputs& wanted, const std::vector<std::string>& inputs,
                                 const std::string& command_line, Outputs& outputs,
                                 const std::function<ExperimentResult()>& work) {
  for (const std::string& input : inputs) outputs.protect_input(input);
  outputs.claim(wanted.report);
  outputs.claim(wanted.json);
  outputs.claim(wanted.out);
  ExperimentResult result;
  try {
    result = work();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  CommandResult given{result_text(result), published_text(result_json(result), kExperimentSchema),
                      std::move(result.file)};
  outputs.set(wanted.json, given.json);
  outputs.set(wanted.out, given.file);
  if (!wanted.report.empty()) {
    outputs.set(wanted.report, render_report(result_report(result, command_line)));
  }
  return given;
}

}  // namespace slipstack::workbench
