// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/experiment_outputs.h"

#include <nlohmann/json.hpp>

#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {

void claim_outputs(const ExperimentOutputs& outputs, const std::vector<std::string>& inputs, Outputs& files) {
  for (const std::string& input : inputs) files.protect_input(input);
  files.claim(outputs.report);
  files.claim(outputs.json);
  files.claim(outputs.out);
}

void set_outputs(const ExperimentOutputs& outputs, const ExperimentResult& result,
                 const std::string& command_line, Outputs& files) {
  files.set(outputs.json, json_text(result_json(result)));
  files.set(outputs.out, result.file);
  if (!outputs.report.empty()) {
    files.set(outputs.report, render_report(result_report(result, command_line)));
  }
}

}  // namespace slipstack::workbench
