// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/add_effect.h"

#include <utility>

#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/model_notes.h"

namespace slipstack::workbench {
namespace {

struct Addition {
  FittedModel before;
  FittedModel after;
  double criterion_difference = 0.0;
  FittedModel reduced;  ///< `after` as the controller runs it
};

/// Fits the old model and the model with the effect to what is searched, then their gains to the whole logs.
Addition fit_addition(LogSearch& logs, const Model& old, const EffectDescription& effect,
                      Progress& progress) {
  const Measurement& measurement = logs.measurement();
  Addition addition;
  progress.show("fit the model as it is");
  addition.before = fit_gains(measurement, terms_on(measurement, old.terms));
  progress.show("add the effect");
  const Trial trial = try_effect(measurement, addition.before, effect, {});
  addition.after = with_standard_errors(
      measurement,
      refine_shapes_in_turn(measurement, fit_gains(measurement, trial.terms, &addition.before), {}));
  const Criterion criterion(measurement, addition.before.terms, 1);
  addition.criterion_difference = criterion.difference(addition.after, addition.before);
  progress.show("judge on unseen data");
  judge_on_unseen_data(measurement, addition.before);
  judge_on_unseen_data(measurement, addition.after);
  progress.show("reduce to the controller");
  addition.reduced = on_controller(measurement, addition.after);
  logs.fit_to_whole({&addition.before, &addition.reduced, &addition.after}, 0.0);
  return addition;
}

}  // namespace

AdditionResult add_effect(LogSearch& logs, const std::string& log, const Model& old,
                          const EffectDescription& effect, Progress& progress) {
  std::vector<std::string> ids = ids_of(old.terms);
  ids.push_back(effect.id());
  Addition addition;
  do {
    check_combination(logs.measurement(), ids);
    check_enough(log, logs.measurement(), ids);
    addition = fit_addition(logs, old, effect, progress);
  } while (logs.extend());
  Measurement& measurement = logs.measurement();

  AdditionResult result;
  result.log = log;
  result.effect = effect.id();
  result.title = effect.text.title;
  result.criterion_difference = addition.criterion_difference;
  result.before = std::move(addition.before);
  result.after = std::move(addition.after);
  lower_noise_floor(measurement, *result.after.linearisation, result.after.holdout_rmse_N);
  result.noise_floor_N = measurement.noise_floor_N();
  result.logs = log_results(measurement, result.after);
  result.model = model_of(log, measurement, result.after, addition.reduced, result.noise_floor_N);
  result.model.history = old.history;
  result.model.history.push_back(change_of(log, {effect.id()}, result.before.holdout_rmse_N,
                                           result.after.holdout_rmse_N, result.noise_floor_N));
  return result;
}

}  // namespace slipstack::workbench
