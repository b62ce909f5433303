// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "workbench/analysis/compare_model.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {

void run_compare(const Options& options) {
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.protect_input(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Model model = read_model(options.model);
  Progress progress;
  LogSearch logs(log_request(options), progress);
  ComparisonResult result = compare_model(logs, std::move(model), progress);
  result.command_line = options.command_line;
  result.log = options.log;
  result.model_path = options.model;
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(comparison_page(measurement, result)));
  }
  outputs.set(options.json, json_text(comparison_json(measurement, result)));
  progress.finish();
  outputs.commit(comparison_text(measurement, result));
}

}  // namespace slipstack::workbench
