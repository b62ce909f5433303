// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/report/comparison_result.h"
#include "workbench/report/json_values.h"
#include "workbench/report/page/html.h"

namespace slipstack::workbench {
namespace {

/// The error of the model as it is: nothing is fitted.
void compare(LogSearch& logs, ComparisonResult& result) {
  const Measurement& measurement = logs.measurement();
  const bool several = measurement.log_count() > 1;  // each with the load that it declares
  const Terms terms = several ? terms_on(measurement, result.model.terms) : result.model.terms;
  result.rows = {measurement.force_N(measurement_dynamics_of(terms)),
                 measurement.filtered(evaluate_force(measurement, terms).force_N)};
  const Eigen::VectorXd& usable = measurement.row_usable();
  const Eigen::VectorXd residual_N = result.rows.residual_N().cwiseProduct(usable);
  result.rmse_N = measurement.weighted_rms(residual_N);
  result.relative_error =
      residual_N.norm() / std::max(result.rows.measured_N.cwiseProduct(usable).norm(), 1e-300);
  std::vector<LogErrors> whole_errors;
  if (measurement.is_excerpt()) {
    WholeLogs::Residual left = logs.residuals_of({terms}).front();
    result.rmse_N = left.rmse_N;
    result.relative_error = left.relative_error;
    whole_errors = std::move(left.logs);
  }
  result.noise_floor_N = measurement.noise_floor_N();
  result.logs = log_results(measurement, result.rows, nullptr, whole_errors);
  result.left = dependence_of(measurement, residual_N);
}

}  // namespace

void run_compare(const Options& options) {
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.protect_input(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  ComparisonResult result;
  result.command_line = options.command_line;
  result.log = options.log;
  result.model_path = options.model;
  result.model = read_model(options.model);
  Progress progress;
  LogSearch logs(log_request(options), progress);
  do {
    progress.show("compare");
    compare(logs, result);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(comparison_page(measurement, result)));
  }
  outputs.set(options.json, json_text(comparison_json(measurement, result)));
  progress.finish();
  outputs.commit(comparison_text(measurement, result));
}

}  // namespace slipstack::workbench
