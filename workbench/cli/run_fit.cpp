// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/estimate/uncertainty/unseen_error.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/report/fit_result.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/page/html.h"

namespace slipstack::workbench {
namespace {

/// The effects of --effects, and those that --effect defines.
std::vector<std::string> effects_to_fit(const Options& options) {
  const std::vector<const EffectDescription*> user_effects = declare_effects(options.user_effects);
  std::vector<std::string> ids = parse_effects(options.effects);
  for (const EffectDescription* effect : user_effects) {
    if (std::find(ids.begin(), ids.end(), effect->id()) == ids.end()) ids.push_back(effect->id());
  }
  return ids;
}

void refine_by_simulation(const Options& options, const Measurement& measurement, Progress& progress,
                          FitResult& result, FittedModel& reduced) {
  result.simulation =
      fit_by_simulation(options.log, measurement, result.fitted, options.horizon_s,
                        [&](double fraction) { progress.show("fit by simulation", fraction); });
  reduced = with_refined_gains(measurement, result.fitted, result.simulation->model, std::move(reduced));
  result.fitted = result.simulation->model;
}

}  // namespace

void run_fit(const Options& options) {
  const std::vector<std::string> ids = effects_to_fit(options);
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.claim(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Progress progress;
  FitResult result;
  result.command_line = options.command_line;
  result.log = options.log;
  result.model_path = options.model;
  result.effects = ids;
  FittedModel reduced;
  LogSearch logs(log_request(options), progress);
  do {
    Measurement& searched = logs.measurement();
    check_combination(searched, ids);
    check_enough(options.log, searched, ids);
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
    if (options.criterion == "simulation") refine_by_simulation(options, searched, progress, result, reduced);
    logs.fit_to_whole({&result.fitted, &reduced}, robust.limit_N);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();
  result.noise_floor_N = measurement.noise_floor_N();
  result.warnings = input_warnings(measurement);
  result.logs = log_results(measurement, result.fitted);
  result.model = model_of(options.log, measurement, result.fitted, reduced, result.noise_floor_N);
  result.model.history = {
      change_of(options.log, ids, 0.0, result.fitted.holdout_rmse_N, result.noise_floor_N)};
  if (!options.report.empty()) outputs.set(options.report, render_report(fit_page(measurement, result)));
  if (!options.model.empty()) outputs.set(options.model, to_toml(result.model));
  outputs.set(options.json, json_text(fit_json(measurement, result)));
  progress.finish();
  outputs.commit(fit_text(measurement, result));
}

}  // namespace slipstack::workbench
