// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/implausible_causes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "firmware/effects/position_dependent_preload.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/alternatives/load_reversals.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

bool has_no_true_gap(const Measurement& measurement, const FittedModel& model) {
  // Of the mass of the axis, of which a part is behind a gap, found to a quarter (kErrorOfGap). Chosen.
  constexpr double kMostOfMass = 1.5;
  const Term* const gap = find_cause(model.terms, CauseForm::gap_in_drive);
  if (gap == nullptr) return false;
  if (gap->gains[0] > kMostOfMass * mass_kg(model.terms)) return true;
  // Within a step the encoder does not show where the axis is.
  if (gap->shapes[0] < 2.0 * measurement.encoder_resolution_m()) return true;
  const Term* const hysteresis = find_role(model.terms, Role::hysteresis);
  const double behind_N = gap->gains[0] * gap->shapes[1];  // mass times deceleration by friction
  return hysteresis == nullptr || behind_N < kMajority * hysteresis_level_N(*hysteresis, 0);
}

bool has_no_true_friction_ripple(const Measurement& measurement, const FittedModel& model) {
  const Term* const ripple = find_cause(model.terms, CauseForm::friction_ripple);
  if (ripple == nullptr) return false;
  // Of the map over the travel: what it can follow is no friction that repeats.
  constexpr double kValues = kPreloadMapSplines;
  if (ripple->shapes[0] > 4.0 / kValues * measurement.position_range_m().length()) return true;
  if (find_cause(model.terms, CauseForm::second_ripple) != nullptr) return false;
  Terms other = without(model.terms, ripple->id());
  other.push_back(make_term(measurement, cause_of(CauseForm::second_ripple)));
  other.back().shapes = ripple->shapes;
  return !is_worth_a_name(fit_gains(measurement, std::move(other), &model).holdout_rmse_N,
                          model.holdout_rmse_N);
}

bool has_no_true_bristle(const Measurement& measurement, const FittedModel& model) {
  const Term* const bristle = find_cause(model.terms, CauseForm::bristle);
  if (bristle == nullptr) return false;
  const Term* const hysteresis = find_role(model.terms, Role::hysteresis);
  if (hysteresis == nullptr ||
      bristle->gains[0] < kMajority * (bristle->gains[0] + hysteresis_level_N(*hysteresis))) {
    return true;
  }
  const FittedModel other = fit_gains(measurement, without(model.terms, bristle->id()), &model);
  return !explains_most(other.holdout_rmse_N, model.holdout_rmse_N, measurement.noise_floor_N());
}

bool has_no_true_power(const Measurement& measurement, const FittedModel& model) {
  const Term* const power = find_cause(model.terms, CauseForm::power_of_velocity);
  if (power == nullptr) return false;
  if (is_at_bound({0, kLeastExponent, kMostExponent, false}, power->shapes[0])) return true;
  const FittedModel other = fit_gains(measurement, without(model.terms, power->id()), &model);
  return !explains_most(other.holdout_rmse_N, model.holdout_rmse_N, measurement.noise_floor_N());
}

bool has_one_ripple_twice(const Measurement& measurement, const Terms& terms) {
  const Term* const second = find_cause(terms, CauseForm::second_ripple);
  if (second == nullptr) return false;
  const double travel_m = measurement.position_range_m().length();
  return std::any_of(terms.begin(), terms.end(), [&](const Term& first) {
    const auto pitch_m = first.shape(ShapeKind::pitch);
    return pitch_m && &first != second && first.effect->acts_as(Acts::force) &&
           std::abs(1.0 / *pitch_m - 1.0 / second->shapes[0]) * travel_m < 1.0;
  });
}

bool lasts_most_of_the_time(const Measurement& measurement, const FittedModel& model) {
  const Term* const after = find_cause(model.terms, CauseForm::after_load_reversals);
  if (after == nullptr) return false;
  LoadReversals load({.deceleration_mps2 = after->shapes[1], .slip_m = after->shapes[2]},
                     measurement.tick_s());
  std::size_t within = 0;
  for (std::size_t p = 0; p < measurement.parts().size(); ++p) {
    const LogPart& part = measurement.parts()[p];
    load.reset(measurement.sample(part.first_sample, p));
    for (std::size_t i = part.first_sample + 1; i < part.end_sample(); ++i) {
      load.step(measurement.sample(i, p));
      if (load.since_s() < after->shapes[0]) ++within;
    }
  }
  return static_cast<double>(within) > kMajority * static_cast<double>(measurement.sample_count());
}

}  // namespace slipstack::workbench
