// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench {

/// Mean square of what a model with held-out error `after_N` explains of an error `before_N` [N^2].
inline double explained_N2(double before_N, double after_N) {
  return before_N * before_N - after_N * after_N;
}

/// What steps from one model to the next are held against.
struct SelectionContext {
  const FittedModel& baseline;
  const NoiseFloor& floor;
  double tick_s;
  double bandwidth_Hz;       ///< of the rows
  double reference_error_N;  ///< held-out error of the baseline, or of the first explanation that has dry
                             ///< friction
};

/// Whether the step adds Coulomb friction to hysteresis: both make a force after each reversal.
bool coulomb_joins_hysteresis(const FittedModel& before, const FittedModel& after);

/// Whether the model has a mode that is none: so damped that it does not ring, many times heavier than the
/// axis that it would shake, or of all its mass. A delay bends into such a mode, and so does friction of
/// another form in slow motion of one frequency, at that frequency.
bool has_no_true_mode(const FittedModel& model);

/// Whether the model's frictional lag is the hysteresis' own: over the pre-sliding travel and not in time. A
/// bristle whose level weakens with velocity (LuGre, Leuven) has to creep to its new stretch; no film forms.
bool lag_is_bristle_deflection(const FittedModel& model);

/// Whether the step adds what grows with the force, and no more of it than clocks and sensors err; it
/// explains `step_N2` (mean square) of what `before` leaves.
bool within_instruments(const FittedModel& baseline, double tick_s, const Terms& before, const Terms& after,
                        double step_N2);

/// Whether the step from `before` to `after` is worth its parameters.
bool is_significant(const SelectionContext& context, const FittedModel& before, const FittedModel& after);

/// Whether the first effect explains enough, though not in enough blocks to be sure of: another one may be
/// loud in those where it does nothing, and both together are sure.
bool is_promising(const SelectionContext& context, const FittedModel& first);

/// Frictional lag contains Stribeck friction. Where even the lag ends so far above the floor, its form is not
/// the axis' own either, and its two more shapes bend towards whatever reversals do (a bristle's stretch lags
/// too): there the share alone decides, unless the lag explains nearly all that Stribeck friction leaves.
inline constexpr double kFormIsNotTheAxis = 1.5;

/// Whether the simpler model's held-out error is hardly larger.
bool hardly_worse(const FittedModel& simpler, const FittedModel& best);

/// Whether a simpler model explains as much as the best one, of what the model before them left.
bool explains_as_well(const SelectionContext& context, const FittedModel& simpler, const FittedModel& best,
                      const FittedModel& before);

}  // namespace slipstack::workbench
