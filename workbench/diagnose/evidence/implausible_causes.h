// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

// What a fitted cause outside the catalogue cannot be.

/// Whether the model has a gap with more mass behind it than the axis has, as far as the form of a gap tells
/// it (half more than is true at most: docs/theory.md), or without most of the friction, or within two steps
/// of the encoder. The guideway carries the carriage, so its friction acts there; another form of the
/// hysteresis takes the form of a small mass behind a gap.
bool has_no_true_gap(const Measurement& measurement, const FittedModel& model);

/// Whether the model has a friction that repeats with a pitch which the map over the position resolves,
/// having four values in one, so that it has a name; or one that a force describes as well, which is the same
/// both ways: in a motion one way they are equal.
bool has_no_true_friction_ripple(const Measurement& measurement, const FittedModel& model);

/// Whether the model has a bristle that is not the form of the friction: one with less than half of the dry
/// friction corrects a hysteresis of another form, and one that explains less than half of the mean square
/// that is left beyond the noise floor leaves the cause open. Cost: one fit of gains.
bool has_no_true_bristle(const Measurement& measurement, const FittedModel& model);

/// Whether the model has a friction that grows with a power of the velocity whose exponent ended at an end of
/// its range: it is dry friction or viscous friction; or one that explains less than half of the mean square
/// that is left beyond the noise floor, for any curve over the velocity helps a little. Cost: one fit of
/// gains.
bool has_no_true_power(const Measurement& measurement, const FittedModel& model);

/// Whether the terms have a second ripple of a pitch that the travel does not tell from that of the first:
/// less than a period more or less within it.
bool has_one_ripple_twice(const Measurement& measurement, const Terms& terms);

/// Whether the model has a force after load reversals whose windows make up most of the time of the log: then
/// these are no moments, and a motion to and fro has any force of its own in them.
bool lasts_most_of_the_time(const Measurement& measurement, const FittedModel& model);

}  // namespace slipstack::workbench
