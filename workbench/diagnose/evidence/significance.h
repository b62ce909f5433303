// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench {

/// The part of the mean square of an error `before_N` that a model with held-out error `after_N` explains
/// [N^2].
inline double explained_N2(double before_N, double after_N) {
  return before_N * before_N - after_N * after_N;
}

/// What is needed to judge a step from one model to the next.
struct SelectionContext {
  const FittedModel& baseline;
  const NoiseFloor& floor;
  double tick_s;
  double bandwidth_Hz;       ///< of the rows
  double reference_error_N;  ///< held-out error of the baseline, or of the first explanation that has dry
                             ///< friction
};

/// Whether the step adds Coulomb friction to hysteresis: both change the force after each reversal.
bool coulomb_joins_hysteresis(const FittedModel& before, const FittedModel& after);

/// Whether the model has an implausible mode: overdamped, much heavier than the axis, or holding nearly all
/// of its mass. The parameters of a mode take such values when it fits something else: a delay, or, in slow
/// motion of one frequency, friction of another form.
bool has_no_true_mode(const FittedModel& model);

/// Whether the model's frictional lag is a property of its hysteresis: a lag over the pre-sliding travel and
/// not over time. In bristle models whose level falls with velocity (LuGre, Leuven) the deflection approaches
/// its new value over such a distance, without any memory of a lubricant film.
bool lag_is_bristle_deflection(const FittedModel& model);

/// Whether the step adds an effect that grows with the force, and no more of it than errors of clocks and
/// sensors can cause. `step_N2`: the mean square that the step explains of the error of `before`.
bool within_instruments(const FittedModel& baseline, double tick_s, const Terms& before, const Terms& after,
                        double step_N2);

/// Whether the step from `before` to `after` is significant: the criteria of docs/theory.md, "Diagnosis".
bool is_significant(const SelectionContext& context, const FittedModel& before, const FittedModel& after);

/// Whether the first effect explains enough, even if not in enough blocks to be significant: a second effect
/// may dominate the other blocks, and the pair may be significant.
bool is_promising(const SelectionContext& context, const FittedModel& first);

/// Frictional lag contains Stribeck friction as a special case. Where even the lag leaves more than this
/// multiple of the noise floor, its formula is not that of the axis either, and its two additional shapes fit
/// whatever happens at reversals (the deflection of a bristle lags too). There Stribeck friction is preferred
/// by the explained share alone, unless the lag explains nearly all that Stribeck friction leaves.
inline constexpr double kFormIsNotTheAxis = 1.5;

/// Whether the simpler model's held-out error is hardly larger.
bool hardly_worse(const FittedModel& simpler, const FittedModel& best);

/// Whether a simpler model explains as much as the best one, of what the model before them left.
bool explains_as_well(const SelectionContext& context, const FittedModel& simpler, const FittedModel& best,
                      const FittedModel& before);

}  // namespace slipstack::workbench
