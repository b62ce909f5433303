// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/significance.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// Of what the baseline leaves above the noise floor, the first effect must explain this part (mean square):
/// what quantisation and the form of the virgin curve leave is no effect.
constexpr double kShareOfExcess = 0.25;

/// An error this near to the noise floor has nothing to explain. Encoder steps seen through mass and
/// acceleration can be shrunk by any filter that resembles a resonance; that is no resonance.
constexpr double kNothingToExplain = 1.05;

/// Whether `first` explains enough of what the model `before` it leaves above a floor of `floor_N`.
bool explains_excess(const FittedModel& before, const FittedModel& first, double floor_N) {
  return explained_N2(before.holdout_rmse_N, first.holdout_rmse_N) >=
             kShareOfExcess * explained_N2(before.holdout_rmse_N, floor_N) &&
         before.holdout_rmse_N >= kNothingToExplain * floor_N;
}

/// What grows with the force must explain this share of it: clocks of current and encoder a few per cent of a
/// sample apart, and sensors a per mille off a straight line, are no delay, mode, payload or ripple.
constexpr double kLeastShareOfForce = 1e-3;

/// A lag below this part of a sample is how the recorder stamps them, or a friction that runs ahead of the
/// displacement by its own damping.
constexpr double kLeastDelay = 0.25;

/// Coulomb friction beside hysteresis is hysteresis of a slip distance shorter than the encoder shows: it
/// takes up what quantisation leaves at reversals, and must explain more than that.
constexpr double kShareOfExcessCoulomb = 0.7;

/// Of all dry friction, what it must be: a virgin curve that begins steeply has as much below the encoder's
/// step (a stretched exponential of exponent 0.6 a tenth below a hundredth of its travel).
constexpr double kShareOfDryFriction = 0.10;

/// Sums over the elements of a hysteresis, over all logs that have their own.
struct ElementSums {
  double level_N = 0.0;
  double travel_Nm = 0.0;  ///< level times slip distance: over the level, the mean slip distance
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

/// Of the dry friction of a model, the share that Coulomb friction has.
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

/// A pitch or a frequency is the best of some hundred: so many standard errors are to the best of them what
/// three are to one.
constexpr double kSignificanceOfSearched = 4.5;
/// Nor does chance lower the error by so much on blocks that the fit has not seen: the best of a hundred
/// waves explains some 2 ln 100 of the independent errors, of which a log's reversals alone make dozens.
constexpr double kMoreThanChance = 0.15;

/// Whether the step adds what may repeat at any pitch or frequency.
bool searched_far(const FittedModel& before, const FittedModel& after) {
  return std::any_of(after.terms.begin(), after.terms.end(), [&](const Term& term) {
    const auto& shapes = term.effect->shapes;
    return !contains(before.terms, term.effect->text.id) &&
           std::any_of(shapes.begin(), shapes.end(), [](const ShapeSpec& shape) {
             return shape.kind == ShapeKind::pitch || shape.kind == ShapeKind::frequency;
           });
  });
}

/// A further effect must lower the held-out error by more, since the form of the first is never exactly the
/// axis' own.
constexpr double kLeastFurtherReduction = 0.05;

/// A further effect must explain this much (rms) of what all explain together: the form of the first, never
/// exactly the axis', leaves less. What dry friction explains where the baseline has none does not count: its
/// elements have no form to be wrong.
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

/// An arm may be heavier than the carriage, by so much.
constexpr double kHeaviestArm = 5.0;
/// Of the mass, what must not swing: one that swings as a whole is a filter of the acceleration, and smooths
/// what the encoder's steps make of it.
constexpr double kMostThatSwings = 0.6;

bool has_no_true_mode(const FittedModel& model) {
  const Term* mode = find_role(model.terms, Role::resonance);
  if (mode == nullptr) return false;
  const double moving_kg = mass_kg(model.terms);
  const EffectTraits& traits = mode->effect->traits;
  const PlausibleShape& damping = traits.plausible_shape;
  const bool overdamped = mode->shapes[static_cast<std::size_t>(damping.shape)] > damping.upper;
  const double rigid_kg = mode->gains[static_cast<std::size_t>(traits.axis_mass_gain)];
  // Of a mass that is fitted, the mode has no rigid part: what swings comes to it.
  const bool free = mass_is_free(model.terms);
  const bool swings_as_a_whole = free ? mode->gains[0] > kMostThatSwings * (moving_kg + mode->gains[0])
                                      : rigid_kg < -kMostThatSwings * moving_kg;
  return overdamped || swings_as_a_whole ||
         std::hypot(mode->gains[0], mode->gains[1]) > kHeaviestArm * moving_kg;
}

/// Of a bristle's pre-sliding travel, how far its stretch follows late at most.
constexpr double kLongestInterval = 2.0;
/// A lag in time that much slower than the one over distance, where friction weakens, is none.
constexpr double kNoLagInTime = 10.0;

bool lag_is_bristle_deflection(const FittedModel& model) {
  const Term* lag = find_role(model.terms, Role::friction_memory);
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  if (lag == nullptr || hysteresis == nullptr) return false;
  const ElementSums sums = element_sums(*hysteresis);
  const double velocity_mps = lag->shapes[0];
  const double time_s = lag->shapes[2];
  const double distance_m = lag->shapes[3];
  return distance_m * sums.level_N <= kLongestInterval * sums.travel_Nm &&
         time_s * velocity_mps >= kNoLagInTime * distance_m;
}

bool is_significant(const SelectionContext& context, const FittedModel& before, const FittedModel& after) {
  const Reduction reduced = reduction(before.block_squared_error, after.block_squared_error);
  const bool by_chance = reduced.value < kMoreThanChance && searched_far(before, after);
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

/// A simpler effect is preferred that leaves at most so much more squared error ...
constexpr double kSquaredErrorOfBest = 1.10;

bool hardly_worse(const FittedModel& simpler, const FittedModel& best) {
  return squared(simpler.holdout_rmse_N) <= kSquaredErrorOfBest * squared(best.holdout_rmse_N);
}

/// No mode is heard to ring above this part of the rows' bandwidth: what else explains nearly as much is no
/// less.
constexpr double kObservable = 0.7;

bool mode_is_not_observable(const SelectionContext& context, const Terms& terms) {
  const Term* mode = find_role(terms, Role::resonance);
  return mode != nullptr && mode->shapes[0] > kObservable * context.bandwidth_Hz;
}

/// ... and explains this share of what the best one explains.
constexpr double kShareOfBest = 0.95;

/// A lag that explains this share of what Stribeck friction leaves above the floor bends to no wrong form.
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
