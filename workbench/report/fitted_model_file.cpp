// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/fitted_model_file.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/reduce.h"
#include "workbench/estimate/terms/user_table.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {

namespace {
/// The largest error of a table, as a share of the noise floor: a quarter adds 3 % to the error at most
/// (sqrt(1 + 0.25^2)).
constexpr double kTableShare = 0.25;
}  // namespace

void tabulate_user_effects(const Measurement& measurement, Model& model, double floor_N) {
  Terms kept;
  std::optional<Term> table;
  for (const Term& term : model.target_terms) {
    if (!term.effect->is_user_defined()) {
      kept.push_back(term);
      continue;
    }
    Model::UserEffectOnTarget outcome;
    outcome.id = term.id();
    if (table) {
      outcome.why_not = "the controller has one table, and it is taken";
    } else if (const Tabulated made = tabulate(measurement, term, kTableShare * floor_N); made.table) {
      table = made.table->term;
      outcome = {term.id(),
                 "",
                 made.table->over_velocity ? "velocity" : "position",
                 made.table->from,
                 made.table->to,
                 made.table->reversal_velocity_mps,
                 made.table->largest_error_N,
                 made.table->peak_N};
    } else {
      outcome.why_not = made.why_not;
    }
    model.target_user_effects.push_back(std::move(outcome));
  }
  if (model.target_user_effects.empty()) return;
  if (table) kept.push_back(std::move(*table));
  model.target_terms = std::move(kept);
  const double left_N = measurement.weighted_rms(residual_of(measurement, model.target_terms));
  model.target_holdout_rmse_N = std::max(model.target_holdout_rmse_N, left_N);
}

FittedModel on_controller(const Measurement& measurement, const FittedModel& fitted) {
  FittedModel reduced = reduce_hysteresis(measurement, fitted, kTargetElements);
  judge_on_unseen_data(measurement, reduced);
  return with_standard_errors(measurement, std::move(reduced));
}

Model model_of(const std::string& log, const Measurement& measurement, const FittedModel& fitted,
               const FittedModel& reduced, double floor_N) {
  Model model;
  model.source = {printable(log), static_cast<std::int64_t>(measurement.whole_sample_count()),
                  fitted.holdout_rmse_N, floor_N, fitted.relative_error};
  model.terms = averaged_over_logs(measurement, fitted.terms);
  model.target_terms = averaged_over_logs(measurement, reduced.terms);
  model.target_holdout_rmse_N = reduced.holdout_rmse_N;
  tabulate_user_effects(measurement, model, floor_N);
  return model;
}

}  // namespace slipstack::workbench
