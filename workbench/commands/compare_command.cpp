// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "workbench/analysis/compare_model.h"
#include "workbench/commands/inputs.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {

CommandResult execute_compare(const CommandOptions& options, Outputs& outputs, Progress& progress) {
  spare_logs(options, outputs);
  spare_model(options, outputs);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Model model = model_of(options);
  LogSearch logs(log_request(options), progress);
  ComparisonResult result = compare_model(logs, std::move(model), progress);
  result.command_line = options.command_line;
  result.log = log_names(options);
  result.model_path = options.model;
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(comparison_page(measurement, result)));
  }
  CommandResult given{comparison_text(measurement, result),
                      published_text(comparison_json(measurement, result), "compare-1"), ""};
  outputs.set(options.json, given.json);
  return given;
}

}  // namespace slipstack::workbench
