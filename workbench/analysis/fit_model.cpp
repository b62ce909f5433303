// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/fit_model.h"

#include <utility>

#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/model_notes.h"

namespace slipstack::workbench {
namespace {

void refine_by_simulation(const FitRequest& request, const Measurement& measurement, Progress& progress,
                          FitResult& result, FittedModel& reduced) {
  result.simulation =
      fit_by_simulation(request.log, measurement, result.fitted, request.horizon_s,
                        [&](double fraction) { progress.show("fit by simulation", fraction); });
  reduced = with_refined_gains(measurement, result.fitted, result.simulation->model, std::move(reduced));
  result.fitted = result.simulation->model;
}

}  // namespace

FitResult fit_model(LogSearch& logs, const FitRequest& request, Progress& progress) {
  const std::vector<std::string>& ids = request.effects;
  FitResult result;
  result.log = request.log;
  result.effects = ids;
  FittedModel reduced;
  do {
    Measurement& searched = logs.measurement();
    check_combination(searched, ids);
    check_enough(request.log, searched, ids);
    progress.show("fit");
    const RobustFit robust =
        fit_robustly(searched, refine_nominal_shapes(searched, fit_effects(searched, ids, {})));
    result.outliers = robust.outliers;
    result.first_outlier_s = robust.first_s;
    result.fitted = with_standard_errors(searched, robust.model);
    progress.show("judge on unseen data");
    judge_on_unseen_data(searched, result.fitted);
    progress.show("reduce to the controller");
    reduced = on_controller(searched, result.fitted);
    if (request.by_simulation) refine_by_simulation(request, searched, progress, result, reduced);
    logs.fit_to_whole({&result.fitted, &reduced}, robust.limit_N);
  } while (logs.extend());
  Measurement& measurement = logs.measurement();
  lower_noise_floor(measurement, *result.fitted.linearisation, result.fitted.holdout_rmse_N);
  result.noise_floor_N = measurement.noise_floor_N();
  result.warnings = input_warnings(measurement);
  result.logs = log_results(measurement, result.fitted);
  result.model = model_of(request.log, measurement, result.fitted, reduced, result.noise_floor_N);
  result.model.history = {
      change_of(request.log, ids, 0.0, result.fitted.holdout_rmse_N, result.noise_floor_N)};
  return result;
}

}  // namespace slipstack::workbench
