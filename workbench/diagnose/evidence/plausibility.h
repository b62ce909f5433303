// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

// What a fitted effect cannot be, whatever the log says: physics beside the evidence.

/// Above this multiple of the noise floor, the form of a model is not that of the axis: what is left may be
/// fitted by an effect of a similar form. The middle between EMPS (2.1) and the blind bench (1.3 at most).
inline constexpr double kFormIsNotTheAxis = 1.65;

/// The largest factor by which a property of an axis changes. No preload, film or warming makes dry friction
/// more than four times as large (the largest value of the map over position in the catalogue, and of
/// Stribeck friction), and no payload the mass; of a scale, a factor and its reciprocal are changes of equal
/// size (Jeffreys 1961, 3.1). A mass that differs by more is in another unit: kgf for N is a factor of 9.8.
inline constexpr double kMostChange = 4.0;

/// What the hysteresis of a model leaves of one of another form, as a share of its level (rms); an effect of
/// a similar form explains some of it. On 39 training logs with friction of the models of the literature,
/// nothing hidden and noise below this share it is 0.48 % at most (docs/theory.md).
inline constexpr double kFormLeaves = 0.005;
/// What causes a force that is too small for a name, for people.
inline constexpr const char* kTooSmall =
    "what clocks and sensors err, or a hysteresis of another form leaves";

/// Whether the gain ended at a bound other than zero, so that the bound determined it and not the log: one of
/// its own, or the gain of another effect of `model` that it is a part of (PartOfAnother). False of a given
/// gain.
bool gain_ended_at_bound(const Terms& model, const Term& term, std::size_t gain);

/// Whether the model's frictional lag is a property of its hysteresis: a lag over the pre-sliding travel and
/// not over time. In bristle models whose level falls with velocity (LuGre, Leuven) the deflection approaches
/// its new value over such a distance, without any memory of a lubricant film.
bool lag_is_bristle_deflection(const FittedModel& model);

/// Whether the model's frictional lag lasts shorter, at the Stribeck velocity, than any memory of the
/// velocity that was measured, or no longer than a sample, which is the end of its search: then friction
/// follows the velocity at once, as far as the log shows, which is Stribeck friction.
bool lag_is_immediate(const Measurement& measurement, const FittedModel& model);

/// Whether the model's frictional lag lasts longer than any memory of the velocity that was measured, and
/// over more than the travel of the log: what it follows is time.
bool lag_is_change_over_time(const Measurement& measurement, const FittedModel& model);

/// Whether the Coulomb friction of a model is part of its hysteresis: the steep start of a virgin curve,
/// which an encoder cannot distinguish from a step; or a correction of a virgin curve of another form, which
/// shows by an error that stays above the noise floor `floor_N`.
bool coulomb_is_of_hysteresis(const FittedModel& model, double floor_N);

/// Whether most of what the model changes the force of the baseline by, which has hysteresis, lies within one
/// sample of a reversal: between two samples nobody has seen where the axis turned round.
bool coulomb_is_of_sampling(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model);

/// The least rms of a force that is named as `effect` beside `model` [N], of what the model does not explain:
/// what clocks and sensors err of the measured force `measured_N` (rms), and what the hysteresis of the model
/// leaves of one of another form, unless the effect repeats along the rail, which hysteresis does not. The
/// latter is not asked of a cause outside the catalogue: an event is short.
double least_named_N(const EffectDescription& effect, double measured_N, const Terms& model);

/// What the masses of `after`, which has a mode, lower the mean square error of `before` by where the mode
/// does nothing but smooth the rounding of the encoder (rounding_through_masses_N2()) [N^2]; zero without a
/// mode. On 12 training logs of a rigid axis a mode lowers the error by 0.8 to 2.2 times that
/// (docs/theory.md). Cost: two realisations of the rounding.
double smoothed_rounding_N2(const Measurement& measurement, const Terms& before, const Terms& after);

/// The mean square of the force that moves the axis, at the frequency of the mode of the model, as far as the
/// encoder rounds, q/sqrt(12) rms (Bennett 1948) [N^2]; 0 without a mode. An axis without the mode that moved
/// that much less or more has the same readings. Where the controller answers the encoder's steps they are
/// not noise that is independent of the force, and a mode of less imitates the controller; so does the skew
/// of two clocks. On 27 training logs true modes move the axis by 2.1 times the rounding or more, the false
/// ones of ten logs by 0.1 to 1.1 times (docs/theory.md).
double rounded_motion_N2(const Measurement& measurement, const Terms& model);

/// Whether the step adds an effect that grows with the force, and no more of it than errors of clocks and
/// sensors can cause, or a mode of whose force (rms) smoothed_rounding_N2() is most, or that explains less
/// than rounded_motion_N2() where `before` has no payload that shows its mass. `step_N2`: the mean square
/// that the step explains of the error of `before`.
bool within_instruments(const Measurement& measurement, const FittedModel& baseline, const Terms& before,
                        const Terms& after, double step_N2);

/// Whether the step is within_instruments(), or adds less of an effect than least_named_N().
bool is_too_small(const Measurement& measurement, const FittedModel& baseline, const Terms& before,
                  const Terms& after, double step_N2);

/// Whether `model` has a mode that the baseline does not have and that is none: by its damping or its mass
/// (has_no_true_mode()), because the search of its frequency ended at the band (above it unless it
/// explains most of what a payload in its place leaves), because it does not decay within the log, because it
/// moves the axis by no more than rounded_motion_N2() (unless a payload in its place shows its mass, and it
/// explains more than smoothed_rounding_N2() beside), or because it is a line of one phase throughout. Cost:
/// some spectra of the rows, a fit of the gains.
bool has_implausible_mode(const Measurement& measurement, const FittedModel& baseline,
                          const FittedModel& model);

/// Whether `model` has an effect, that the baseline does not have, with a pitch or a delay at an
/// end of the range within which it was searched.
bool has_shape_at_bound(const Measurement& measurement, const FittedModel& baseline,
                        const FittedModel& model);

/// Whether `model` has a frictional lag that the baseline does not have and that is none: with a gain at a
/// bound, of a bristle, or a change over time.
bool has_implausible_lag(const Measurement& measurement, const FittedModel& baseline,
                         const FittedModel& model);

/// Whether `model` has an effect that the baseline does not have and that is none: one with a gain at a bound
/// other than zero, or a pitch or delay at one (the bound determined it, not the log), one that
/// makes dry friction anywhere in the log more than four times as large or as small, a mode that does not
/// ring or lies above the band, a lag of bristles, Coulomb friction of the hysteresis, a gap in the drive
/// with less than half of the friction behind it, or a ripple that does not repeat along the rail
/// (repeats.h). Cost: one evaluation of each effect that modulates friction.
bool is_implausible(const Measurement& measurement, const FittedModel& baseline, const FittedModel& model);

}  // namespace slipstack::workbench
