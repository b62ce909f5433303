// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "workbench/base/interval.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

// Samples that show a fault of the recorder or a sensor, not the axis. `noise_N`: standard deviation of the
// noise of the force. All functions are O(n).

/// The smallest non-zero difference between neighbours: the resolution of a digital signal; infinite for a
/// constant one.
double smallest_step(const std::vector<double>& values);

/// Samples for which the force is held: more than 1 where nearly all of its changes are as many samples
/// apart, as where it is recorded at a lower rate than the position.
std::size_t held_samples(const std::vector<double>& force_N);

/// Intervals in which the force stays at its largest or its smallest value, so long as noise makes it by
/// chance nowhere.
std::vector<Interval> force_at_limit(const std::vector<double>& force_N);

/// Intervals in which the force does not change, though it has noise elsewhere.
struct ConstantForce {
  std::vector<Interval> at_limit;
  std::vector<Interval> frozen;
  bool noise_at_standstill = true;  ///< false: constant at standstill, as a commanded current is
};
ConstantForce constant_force(const Log& log, double noise_N);

/// Samples lost by the recorder, which wrote the last one again: force and position as in the sample before,
/// in runs shorter than those of a frozen force. Not where the force has no noise on both sides.
std::vector<Interval> repeated_samples(const Log& log, double noise_N);
/// Whether so many repeated samples occur by chance, or are a property of the log.
bool repeat_by_chance(const Log& log, double noise_N, std::size_t repeats);

/// Intervals in which the encoder stands still and then jumps to the true position.
std::vector<Interval> stuck_encoder(const Log& log);
/// The last interval of constant position, where the axis cannot have stood still: it stopped from full speed
/// within a sample, or the force varies there as in no other standstill.
std::optional<Interval> stuck_to_the_end(const Log& log);
/// Whether the axis entered the interval of constant position that ends before `sample` at speed and stopped
/// within one sample, which a mass cannot.
bool stopped_dead(const Log& log, std::size_t sample);
/// Whether the force varies, in the interval of constant position that ends before `sample`, far more than in
/// any other standstill.
bool force_shows_motion(const Log& log, std::size_t sample);

/// Intervals of motion without any force, as when the axis is moved by hand with the drive off: it starts
/// from rest, or the force is switched while the axis moves on. Where inertia, friction and gravity cancel,
/// the force passes zero evenly.
std::vector<Interval> forceless_motion(const Log& log, double noise_N);

}  // namespace slipstack::workbench
