// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/plausibility.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/repeats.h"

namespace slipstack::workbench {
namespace {

/// An effect whose force grows with the measured force (delay, mode, payload, motor constant) must explain
/// this share of that force (rms). Instruments cause less: clocks of current and encoder that differ by a few
/// per cent of a sample, sensors that deviate from linearity by a per mille.
constexpr double kLeastShareOfForce = 1e-3;

/// A delay below this part of a sample is not named: it may come from how the recorder assigns time stamps,
/// or from the damping of bristles, whose friction leads the displacement.
constexpr double kLeastDelay = 0.25;

/// Level times slip distance over the elements of a hysteresis; divided by its level, the mean slip distance.
double travel_Nm(const Term& hysteresis) {
  double sum_Nm = 0.0;
  for (std::size_t i = 0; i < hysteresis.gains.size(); ++i) {
    const double slip_m = hysteresis.shapes[i % hysteresis.gains_per_set()];
    sum_Nm += hysteresis.gains[i] * slip_m * slip_m;
  }
  return sum_Nm;
}

}  // namespace

bool within_instruments(const FittedModel& baseline, double tick_s, const Terms& before, const Terms& after,
                        double step_N2) {
  if (has_role(after, Role::measurement_delay) && !has_role(before, Role::measurement_delay) &&
      std::abs(measurement_dynamics_of(after).total_s()) < kLeastDelay * tick_s) {
    return true;
  }
  if (!(baseline.relative_error > 0.0)) return false;
  const double force_N = baseline.train_rmse_N / baseline.relative_error;
  return step_N2 < squared(kLeastShareOfForce * force_N) &&
         std::any_of(after.begin(), after.end(), [&](const Term& term) {
           return term.effect->traits.grows_with_force && !contains(before, term.effect->text.id);
         });
}

/// Coulomb friction beside hysteresis must be this share of the dry friction. A virgin curve with a steep
/// start reaches as much within one encoder step (a stretched exponential of exponent 0.6 reaches a tenth of
/// its level within a hundredth of its travel).
constexpr double kLeastShareOfDry = 0.10;

bool coulomb_is_of_hysteresis(const FittedModel& model, double floor_N) {
  const Term* coulomb = find_role(model.terms, Role::saturating_friction);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (coulomb == nullptr || hysteresis == nullptr) return false;
  const double level_N = hysteresis_level_N(*hysteresis) / static_cast<double>(hysteresis->gain_sets());
  const double coulomb_N = std::abs(coulomb->gains[0]);
  return coulomb_N < kLeastShareOfDry * (coulomb_N + level_N) ||
         model.holdout_rmse_N > kFormIsNotTheAxis * floor_N;
}

/// A mode whose mass exceeds this multiple of the moving mass is implausible. Chosen.
constexpr double kHeaviestArm = 5.0;
/// A mode that holds more than this share of the whole mass is implausible: where all of the mass swings, the
/// mode is only a filter of the acceleration, which smooths the effect of encoder steps.
constexpr double kLargestModalShare = 0.6;

bool has_no_true_mode(const FittedModel& model) {
  const Term* mode = find_role(model.terms, Role::resonance);
  if (mode == nullptr) return false;
  const double moving_kg = mass_kg(model.terms);
  const EffectTraits& traits = mode->effect->traits;
  const PlausibleShape& damping = traits.plausible_shape;
  const double damping_ratio = mode->shapes[static_cast<std::size_t>(damping.shape)];
  const bool implausibly_damped = damping_ratio < damping.lower || damping_ratio > damping.upper;
  const double rigid_kg = mode->gains[static_cast<std::size_t>(traits.axis_mass_gain)];
  // Where the mass is fitted, the mode has no rigid part, and its mass is not contained in `moving_kg`.
  const bool free = mass_is_free(model.terms);
  const bool swings_as_a_whole = free ? mode->gains[0] > kLargestModalShare * (moving_kg + mode->gains[0])
                                      : rigid_kg < -kLargestModalShare * moving_kg;
  return implausibly_damped || swings_as_a_whole ||
         std::hypot(mode->gains[0], mode->gains[1]) > kHeaviestArm * moving_kg;
}

/// The deflection of a bristle lags behind by at most this multiple of the mean slip distance.
constexpr double kLongestLag = 2.0;
/// A lag in time counts as absent where, at the Stribeck velocity, it acts over this multiple of the distance
/// over which the lag in distance acts.
constexpr double kNoLagInTime = 10.0;

bool lag_is_bristle_deflection(const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (lag == nullptr || hysteresis == nullptr) return false;
  const double velocity_mps = lag->shapes[0];
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  return distance_m * hysteresis_level_N(*hysteresis) <= kLongestLag * travel_Nm(*hysteresis) &&
         time_s * velocity_mps >= kNoLagInTime * distance_m;
}

bool is_implausible(const Measurement& measurement, const NoiseFloor& floor, const FittedModel& baseline,
                    const FittedModel& model) {
  const bool has_new_coulomb = has_role(model.terms, Role::saturating_friction) &&
                               !has_role(baseline.terms, Role::saturating_friction);
  return (has_no_true_mode(model) && !has_no_true_mode(baseline)) ||
         (lag_is_bristle_deflection(model) && !has_role(baseline.terms, Role::friction_memory)) ||
         (has_new_coulomb && coulomb_is_of_hysteresis(model, floor.of(model.terms))) ||
         ripple_not_supported(measurement, model, baseline.terms);
}

}  // namespace slipstack::workbench
