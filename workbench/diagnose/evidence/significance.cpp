// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/significance.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// The first effect must explain this share (mean square) of the baseline's error above the noise floor. Less
/// than that is also left by quantisation and by an imperfect virgin curve. Chosen on the blind bench
/// (tests/bench/blind).
constexpr double kShareOfExcess = 0.25;

/// Where the error is below this multiple of the noise floor, no effect is named. Encoder steps, which mass
/// times acceleration turns into force, are reduced by any filter that resembles a resonance.
constexpr double kNothingToExplain = 1.05;

/// Whether `first` explains enough of the error of `before` above a noise floor of `floor_N`.
bool explains_excess(const FittedModel& before, const FittedModel& first, double floor_N) {
  return explained_N2(before.holdout_rmse_N, first.holdout_rmse_N) >=
             kShareOfExcess * explained_N2(before.holdout_rmse_N, floor_N) &&
         before.holdout_rmse_N >= kNothingToExplain * floor_N;
}

/// An effect whose force grows with the measured force (delay, mode, payload, motor constant) must explain
/// this share of that force (rms). Instruments cause less: clocks of current and encoder that differ by a few
/// per cent of a sample, sensors that deviate from linearity by a per mille.
constexpr double kLeastShareOfForce = 1e-3;

/// A delay below this part of a sample is not named: it may come from how the recorder assigns time stamps,
/// or from the damping of bristles, whose friction leads the displacement.
constexpr double kLeastDelay = 0.25;

/// Coulomb friction added to hysteresis equals an element of a slip distance shorter than an encoder step. It
/// fits part of what quantisation leaves at reversals, so it must explain this share of the error above the
/// noise floor (mean square). Chosen on the blind bench.
constexpr double kShareOfExcessCoulomb = 0.7;

/// Coulomb friction added to hysteresis must be this share of the dry friction. A virgin curve with a steep
/// start reaches as much within one encoder step (a stretched exponential of exponent 0.6 reaches a tenth of
/// its level within a hundredth of its travel).
constexpr double kShareOfDryFriction = 0.10;

/// Sums over the elements of a hysteresis; over all logs where each has its own gains.
struct ElementSums {
  double level_N = 0.0;
  double travel_Nm = 0.0;  ///< level times slip distance; divided by the level the mean slip distance
};
ElementSums element_sums(const Term& hysteresis) {
  ElementSums sums;
  for (std::size_t i = 0; i < hysteresis.gains.size(); ++i) {
    const double slip_m = hysteresis.shapes[i % hysteresis.shapes.size()];
    const double level_N = hysteresis.gains[i] * slip_m;
    sums.level_N += level_N;
    sums.travel_Nm += level_N * slip_m;
  }
  return sums;
}

/// The share of Coulomb friction in the dry friction of a model.
double coulomb_share(const FittedModel& model) {
  double coulomb_N = 0.0;
  double hysteresis_N = 0.0;
  if (const Term* term = find_role(model.terms, Role::saturating_friction)) {
    coulomb_N = std::abs(term->gains[0]);
  }
  if (const Term* term = find_role(model.terms, Role::hysteresis)) {
    hysteresis_N = element_sums(*term).level_N / static_cast<double>(term->gain_sets());
  }
  return coulomb_N / std::max(coulomb_N + hysteresis_N, 1e-300);
}

/// A pitch or a frequency is the best of about a hundred that were tried. For the maximum of a hundred, 4.5
/// standard errors are as improbable as three are for one (Bonferroni).
constexpr double kSignificanceOfSearched = 4.5;
/// A larger reduction of the held-out error than this does not occur by chance, whatever its standard error:
/// the best of a hundred waves explains about 2 ln 100 of the independent errors, and the reversals of a log
/// alone make dozens of those.
constexpr double kMoreThanChance = 0.15;

/// Whether the step adds an effect whose pitch or frequency was searched over a wide range.
bool was_searched_widely(const FittedModel& before, const FittedModel& after) {
  return std::any_of(after.terms.begin(), after.terms.end(), [&](const Term& term) {
    const auto& shapes = term.effect->shapes;
    return !contains(before.terms, term.effect->text.id) &&
           std::any_of(shapes.begin(), shapes.end(), [](const ShapeSpec& shape) {
             return shape.kind == ShapeKind::pitch || shape.kind == ShapeKind::frequency;
           });
  });
}

/// Further effects must lower the held-out error by more than the first (kLeastReduction), because the
/// formula of the first is never exactly that of the axis. Chosen on the blind bench.
constexpr double kLeastFurtherReduction = 0.05;

/// A further effect must explain this share (rms) of what all effects explain together: the mismatch between
/// the formula of the first and the axis leaves less. What dry friction explains where the baseline has none
/// does not count, since a hysteresis with free elements has no formula that could mismatch.
constexpr double kShareOfExplained = 0.05;

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

bool coulomb_joins_hysteresis(const FittedModel& before, const FittedModel& after) {
  return has_role(before.terms, Role::hysteresis) && !has_role(before.terms, Role::saturating_friction) &&
         has_role(after.terms, Role::saturating_friction);
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
  const bool overdamped = mode->shapes[static_cast<std::size_t>(damping.shape)] > damping.upper;
  const double rigid_kg = mode->gains[static_cast<std::size_t>(traits.axis_mass_gain)];
  // Where the mass is fitted, the mode has no rigid part, and its mass is not contained in `moving_kg`.
  const bool free = mass_is_free(model.terms);
  const bool swings_as_a_whole = free ? mode->gains[0] > kLargestModalShare * (moving_kg + mode->gains[0])
                                      : rigid_kg < -kLargestModalShare * moving_kg;
  return overdamped || swings_as_a_whole ||
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
  const ElementSums sums = element_sums(*hysteresis);
  const double velocity_mps = lag->shapes[0];
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  return distance_m * sums.level_N <= kLongestLag * sums.travel_Nm &&
         time_s * velocity_mps >= kNoLagInTime * distance_m;
}

bool is_significant(const SelectionContext& context, const FittedModel& before, const FittedModel& after) {
  const Reduction reduced = reduction(before.block_squared_error, after.block_squared_error);
  const bool by_chance = reduced.value < kMoreThanChance && was_searched_widely(before, after);
  const double significance = by_chance ? kSignificanceOfSearched : kSignificance;
  if (!lowered_significantly(before.block_squared_error, after.block_squared_error, significance))
    return false;
  const double floor_N = context.floor.of(after.terms);
  const double step = explained_N2(before.holdout_rmse_N, after.holdout_rmse_N);
  const double excess = explained_N2(before.holdout_rmse_N, floor_N);
  if (coulomb_joins_hysteresis(before, after) &&
      (step < kShareOfExcessCoulomb * excess || coulomb_share(after) < kShareOfDryFriction)) {
    return false;
  }
  if (within_instruments(context.baseline, context.tick_s, before.terms, after.terms, step)) return false;
  if (before.terms.size() <= context.baseline.terms.size()) return explains_excess(before, after, floor_N);
  const double all = explained_N2(context.reference_error_N, after.holdout_rmse_N);
  return reduced.value >= kLeastFurtherReduction && step >= squared(kShareOfExplained) * all;
}

bool is_promising(const SelectionContext& context, const FittedModel& first) {
  return explains_excess(context.baseline, first, context.floor.of(first.terms)) &&
         first.holdout_rmse_N < (1.0 - kLeastReduction) * context.baseline.holdout_rmse_N;
}

/// A simpler effect is preferred when its squared error is at most this multiple of the other's ...
constexpr double kSquaredErrorOfBest = 1.10;

bool hardly_worse(const FittedModel& simpler, const FittedModel& best) {
  return squared(simpler.holdout_rmse_N) <= kSquaredErrorOfBest * squared(best.holdout_rmse_N);
}

/// Ringing is not observable above this part of the rows' bandwidth, since the filter removes it: any other
/// effect that explains nearly as much is preferred to such a mode.
constexpr double kObservable = 0.7;

bool mode_is_not_observable(const SelectionContext& context, const Terms& terms) {
  const Term* mode = find_role(terms, Role::resonance);
  return mode != nullptr && mode->shapes[0] > kObservable * context.bandwidth_Hz;
}

/// ... and it explains at least this share of what the other explains. Both chosen on the blind bench.
constexpr double kShareOfBest = 0.95;

/// A lag that explains this share of what Stribeck friction leaves above the floor is more than a better fit
/// to another formula: on simulated axes true lags explain 0.74 to 0.88 of it, Stribeck friction of other
/// formulas 0.77 at most (docs/theory.md).
constexpr double kMoreThanForm = 0.8;

bool explains_as_well(const SelectionContext& context, const FittedModel& simpler, const FittedModel& best,
                      const FittedModel& before) {
  if (explained_N2(before.holdout_rmse_N, simpler.holdout_rmse_N) <
      kShareOfBest * explained_N2(before.holdout_rmse_N, best.holdout_rmse_N)) {
    return false;
  }
  if (hardly_worse(simpler, best)) return true;
  if (!has_role(simpler.terms, Role::resonance) && mode_is_not_observable(context, best.terms)) return true;
  const Term* lag = find_role(best.terms, Role::friction_memory);
  const bool nested = lag != nullptr && !has_role(simpler.terms, Role::friction_memory) &&
                      contains(simpler.terms, lag->effect->traits.special_case.id);
  const double floor_N = context.floor.of(best.terms);
  return nested && best.holdout_rmse_N > kFormIsNotTheAxis * floor_N &&
         explained_N2(simpler.holdout_rmse_N, best.holdout_rmse_N) <
             kMoreThanForm * explained_N2(simpler.holdout_rmse_N, floor_N);
}

}  // namespace slipstack::workbench
