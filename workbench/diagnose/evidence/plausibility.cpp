// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/plausibility.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/repeats.h"
#include "workbench/estimate/linear/force_trace.h"

namespace slipstack::workbench {
namespace {

/// The dry friction that an effect leaves, as a multiple of that without it: no preload, film or warming
/// takes all of it away, and none makes it more than four times as large (the largest value of the map over
/// position in the catalogue, and of Stribeck friction).
constexpr double kMostModulation = 4.0;

/// A lag in time is absent where its rate, at the Stribeck velocity, is this share of that of the lag in
/// distance.
constexpr double kNegligibleRate = 0.1;

bool leaves_a_friction(const Measurement& measurement, const Term& term) {
  if (!acts_with_gains(term, Acts::dry_scale)) return true;
  const DryTrace trace = evaluate_dry(measurement, {term});
  return std::all_of(trace.dry_factor.begin(), trace.dry_factor.end(),
                     [](double factor) { return factor > 0.0 && factor <= kMostModulation; });
}

/// Whether any gain ended at a bound other than zero. Given gains do not count.
bool ends_at_a_bound(const Term& term) {
  for (std::size_t i = 0; i < term.gains.size(); ++i) {
    const bool bounded = term.gains[i] == term.lower[i] || term.gains[i] == term.upper[i];
    if (bounded && term.gains[i] != 0.0 && term.lower[i] != term.upper[i]) return true;
  }
  return false;
}

/// Whether a new term of `model` is none, by `is_none`.
template <class IsNone>
bool any_new(const FittedModel& model, const FittedModel& baseline, IsNone&& is_none) {
  return std::any_of(model.terms.begin(), model.terms.end(), [&](const Term& term) {
    return !contains(baseline.terms, term.effect->text.id) && is_none(term);
  });
}

}  // namespace

bool within_instruments(const FittedModel& baseline, double tick_s, const Terms& before, const Terms& after,
                        double step_N2) {
  const double force_N =
      baseline.relative_error > 0.0 ? baseline.train_rmse_N / baseline.relative_error : 0.0;
  return std::any_of(after.begin(), after.end(), [&](const Term& term) {
    if (contains(before, term.effect->text.id)) return false;
    const Plausibility& plausible = term.effect->traits.plausible;
    return std::abs(measurement_dynamics_of({term}).total_s()) < plausible.least_samples * tick_s ||
           step_N2 < squared(plausible.least_share_of_force * force_N);
  });
}

bool coulomb_is_of_hysteresis(const FittedModel& model, double floor_N) {
  const Term* coulomb = find_role(model.terms, Role::saturating_friction);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (coulomb == nullptr || hysteresis == nullptr) return false;
  const double level_N = hysteresis_level_N(*hysteresis) / static_cast<double>(hysteresis->gain_sets());
  const double coulomb_N = std::abs(coulomb->gains[0]);
  return coulomb_N < coulomb->effect->traits.plausible.least_share_of_dry * (coulomb_N + level_N) ||
         model.holdout_rmse_N > kFormIsNotTheAxis * floor_N;
}

bool lag_is_bristle_deflection(const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (lag == nullptr || hysteresis == nullptr) return false;
  const double velocity_mps = lag->shapes[0];
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  return distance_m <= lag->effect->traits.plausible.least_slip_distances * mean_slip_m(*hysteresis) &&
         distance_m <= kNegligibleRate * time_s * velocity_mps;
}

bool is_implausible(const Measurement& measurement, const FittedModel& baseline, const FittedModel& model) {
  const bool has_new_coulomb = has_role(model.terms, Role::saturating_friction) &&
                               !has_role(baseline.terms, Role::saturating_friction);
  return any_new(model, baseline, ends_at_a_bound) ||
         any_new(model, baseline, [&](const Term& term) { return !leaves_a_friction(measurement, term); }) ||
         (has_no_true_mode(model.terms) && !has_no_true_mode(baseline.terms)) ||
         (lag_is_bristle_deflection(model) && !has_role(baseline.terms, Role::friction_memory)) ||
         (has_new_coulomb && coulomb_is_of_hysteresis(model, measurement.noise_floor_N())) ||
         ripple_not_supported(measurement, model, baseline.terms);
}

}  // namespace slipstack::workbench
