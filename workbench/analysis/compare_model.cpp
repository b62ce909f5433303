// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/compare_model.h"

#include <algorithm>
#include <utility>

#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench {
namespace {

void compare(LogSearch& logs, ComparisonResult& result) {
  Measurement& measurement = logs.measurement();
  const bool several = measurement.log_count() > 1;  // each with the load that it declares
  const Terms terms = several ? terms_on(measurement, result.model.terms) : result.model.terms;
  result.rows = force_rows(measurement, result.model.terms);
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
  lower_noise_floor(measurement, Linearisation(measurement, terms), result.rmse_N);
  result.noise_floor_N = measurement.noise_floor_N();
  result.logs = log_results(measurement, result.rows, nullptr, whole_errors);
  result.left = dependence_of(measurement, residual_N);
}

}  // namespace

ForceRows force_rows(const Measurement& measurement, const Terms& terms) {
  const Terms here = measurement.log_count() > 1 ? terms_on(measurement, terms) : terms;
  return {measurement.force_N(measurement_dynamics_of(here)),
          measurement.filtered(evaluate_force(measurement, here).force_N)};
}

ComparisonResult compare_model(LogSearch& logs, Model model, Progress& progress) {
  ComparisonResult result;
  result.model = std::move(model);
  do {
    progress.show("compare");
    compare(logs, result);
  } while (logs.extend());
  result.warnings = input_warnings(logs.measurement());
  return result;
}

}  // namespace slipstack::workbench
