// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/worth.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "workbench/diagnose/reduction.h"

namespace slipstack::workbench {
namespace {

/// Of what the baseline leaves above the noise floor, the first effect must explain this part (mean square):
/// what quantisation and the form of the virgin curve leave is no effect.
constexpr double kShareOfExcess = 0.25;

/// An error this near to the noise floor has nothing to explain. Encoder steps seen through mass and
/// acceleration can be shrunk by any filter that resembles a resonance; that is no resonance.
constexpr double kNothingToExplain = 1.05;

double squared(double x) {
  return x * x;
}

/// Whether `first` explains enough of what the model `before` it leaves above a floor of `floor_N`.
bool explains_excess(const FittedModel& before, const FittedModel& first, double floor_N) {
  return explained_N2(before.holdout_rmse_N, first.holdout_rmse_N) >=
             kShareOfExcess * explained_N2(before.holdout_rmse_N, floor_N) &&
         before.holdout_rmse_N >= kNothingToExplain * floor_N;
}

/// What grows with the force must explain this share of it: clocks of current and encoder a few per cent of a
/// sample apart, and sensors a per mille off a straight line, are no delay, mode, payload or ripple.
constexpr double kLeastShareOfForce = 1e-3;
constexpr std::string_view kGrowWithForce[] = {"time_delay", "structural_resonance", "payload_mass",
                                               "motor_constant_ripple"};

/// Whether the step adds what grows with the force, and no more of it than instruments err.
bool within_instruments(const FittedModel& baseline, const FittedModel& before, const FittedModel& after,
                        double step_N2) {
  if (!(baseline.relative_error > 0.0)) return false;
  const double force_N = baseline.train_rmse_N / baseline.relative_error;
  return step_N2 < squared(kLeastShareOfForce * force_N) &&
         std::any_of(std::begin(kGrowWithForce), std::end(kGrowWithForce), [&](std::string_view id) {
           return contains(after.terms, id) && !contains(before.terms, id);
         });
}

/// Coulomb friction beside hysteresis is hysteresis of a slip distance shorter than the encoder shows: it
/// takes up what quantisation leaves at reversals, and must explain more than that.
constexpr double kShareOfExcessCoulomb = 0.7;

/// A further effect must lower the held-out error by more, since the form of the first is never exactly the
/// axis' own.
constexpr double kLeastFurtherReduction = 0.05;

/// A further effect must explain this much (rms) of what all explain together: the form of the first, never
/// exactly the axis', leaves less. What dry friction explains where the baseline has none does not count: its
/// elements have no form to be wrong.
constexpr double kShareOfExplained = 0.05;

}  // namespace

bool coulomb_joins_hysteresis(const FittedModel& before, const FittedModel& after) {
  return contains(before.terms, "presliding_hysteresis") && !contains(before.terms, "coulomb") &&
         contains(after.terms, "coulomb");
}

bool earned(const Yardstick& yardstick, const FittedModel& before, const FittedModel& after) {
  const Reduction reduced = reduction(before.block_squared_error, after.block_squared_error);
  if (!reduced.earned()) return false;
  const double floor_N = yardstick.floor.of(after.terms);
  const double step = explained_N2(before.holdout_rmse_N, after.holdout_rmse_N);
  const double excess = explained_N2(before.holdout_rmse_N, floor_N);
  if (coulomb_joins_hysteresis(before, after) && step < kShareOfExcessCoulomb * excess) return false;
  if (within_instruments(yardstick.baseline, before, after, step)) return false;
  if (before.terms.size() <= yardstick.baseline.terms.size()) return explains_excess(before, after, floor_N);
  const double all = explained_N2(yardstick.known_N, after.holdout_rmse_N);
  return reduced.value >= kLeastFurtherReduction && step >= squared(kShareOfExplained) * all;
}

bool promises(const Yardstick& yardstick, const FittedModel& first) {
  return explains_excess(yardstick.baseline, first, yardstick.floor.of(first.terms)) &&
         first.holdout_rmse_N < (1.0 - kLeastReduction) * yardstick.baseline.holdout_rmse_N;
}

/// A simpler effect is preferred that leaves at most so much more squared error ...
constexpr double kSquaredErrorOfBest = 1.10;

bool hardly_worse(const FittedModel& simpler, const FittedModel& best) {
  return squared(simpler.holdout_rmse_N) <= kSquaredErrorOfBest * squared(best.holdout_rmse_N);
}

/// ... and explains this share of what the best one explains.
constexpr double kShareOfBest = 0.95;

bool stands_for(const NoiseFloor& floor, const FittedModel& simpler, const FittedModel& best,
                const FittedModel& before) {
  if (explained_N2(before.holdout_rmse_N, simpler.holdout_rmse_N) <
      kShareOfBest * explained_N2(before.holdout_rmse_N, best.holdout_rmse_N)) {
    return false;
  }
  if (hardly_worse(simpler, best)) return true;
  const bool nested = contains(best.terms, "frictional_lag") && !contains(simpler.terms, "frictional_lag") &&
                      contains(simpler.terms, "stribeck");
  return nested && squared(best.holdout_rmse_N) > squared(kFormIsNotTheAxis * floor.of(best.terms));
}

}  // namespace slipstack::workbench
