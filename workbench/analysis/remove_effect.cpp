// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/remove_effect.h"

#include <fmt/format.h>

#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/model_notes.h"

namespace slipstack::workbench {

Refit remove_effect(LogSearch& logs, const std::string& log, const Model& old, const std::string& effect,
                    Progress& progress) {
  if (!contains(old.terms, effect)) {
    throw UsageError(fmt::format("the model does not contain {}", in_quotes(effect)));
  }
  if (old.terms.size() < 2) {
    throw UsageError(fmt::format("{} is the only effect of the model; add another first", effect));
  }
  FittedModel before, after, reduced;
  do {
    const Measurement& measurement = logs.measurement();
    progress.show("fit the model as it is");
    before = fit_gains(measurement, terms_on(measurement, old.terms));
    progress.show("fit without the effect");
    after = with_standard_errors(
        measurement, refine_shapes_in_turn(
                         measurement, fit_gains(measurement, without(before.terms, effect), &before), {}));
    progress.show("judge on unseen data");
    judge_on_unseen_data(measurement, before);
    judge_on_unseen_data(measurement, after);
    progress.show("reduce to the controller");
    reduced = on_controller(measurement, after);
    logs.fit_to_whole({&before, &reduced, &after}, 0.0);
  } while (logs.extend());
  Measurement& measurement = logs.measurement();
  lower_noise_floor(measurement, *before.linearisation, before.holdout_rmse_N);
  Refit refit;
  refit.before_N = before.holdout_rmse_N;
  refit.after_N = after.holdout_rmse_N;
  refit.noise_floor_N = measurement.noise_floor_N();
  refit.model = model_of(log, measurement, after, reduced, refit.noise_floor_N);
  refit.model.history = old.history;
  refit.model.history.push_back(
      change_of(log, {"without " + effect}, refit.before_N, refit.after_N, refit.noise_floor_N));
  return refit;
}

}  // namespace slipstack::workbench
