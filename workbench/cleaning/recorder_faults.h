// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "workbench/base/interval.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

// Where a log tells of its recorder, not of the axis. `noise_N`: standard deviation of the force's noise. All
// O(n).

/// The smallest difference between neighbours that differ: the step of a digital signal; infinite without
/// any.
double smallest_step(const std::vector<double>& values);

/// Where the force does not change, though it has noise elsewhere.
struct ConstantForce {
  std::vector<Interval> at_limit;
  std::vector<Interval> frozen;
  bool noise_at_rest = true;  ///< or it is constant while the axis rests, as a commanded current
};
ConstantForce constant_force(const Log& log, double noise_N);

/// Both force and position as the sample before, for less than a frozen force takes: lost by the recorder,
/// which wrote the last one again. Not where the force is quiet on both sides.
std::vector<Interval> repeated_samples(const Log& log, double noise_N);
/// Whether so many samples repeat the one before by chance, or by the nature of the log.
bool repeat_by_chance(const Log& log, double noise_N, std::size_t repeats);

/// An encoder that stands still and then jumps to where it should be.
std::vector<Interval> stuck_encoder(const Log& log);
/// The last stretch of one position, where the axis cannot have stood: it came in at speed and stopped within
/// a sample, or the force does there what it does nowhere else while the position stands.
std::optional<Interval> stuck_to_the_end(const Log& log);
/// Whether the axis came at speed into the stretch of one position that ends before `sample`, and stopped
/// within a sample: no mass does.
bool stopped_dead(const Log& log, std::size_t sample);
/// Whether in the stretch of one position that ends before `sample` the force does what it does nowhere else
/// while the position stands.
bool force_shows_motion(const Log& log, std::size_t sample);

/// Motion without any force, as by hand with the drive off.
std::vector<Interval> forceless_motion(const Log& log, double noise_N);

}  // namespace slipstack::workbench
