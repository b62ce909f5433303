// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/joined_segments.h"

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

/// Pace of the moves between segments: one half, since they are not part of the experiment; slower where the
/// limit of the force requires it. Acceleration is proportional to the square of the pace.
double pace_of(const AxisLimits& limits, const Terms& model) {
  constexpr double kHalf = 0.5;
  // In a log the force and the acceleration are those of one motion.
  if (limits.force_N <= 0.0 || limits.force_of_log || mass_kg(model) <= 0.0) return kHalf;
  const double left_N = 0.8 * limits.force_N - friction_level_N(model);
  const double full_N = mass_kg(model) * limits.acceleration_mps2;
  return std::clamp(std::sqrt(std::max(left_N, 0.0) / full_N), 0.05, kHalf);
}

}  // namespace

std::vector<int> Sequence::groups_of(const Measurement& measurement) const {
  std::vector<int> groups;
  groups.reserve(measurement.row_samples().size());
  std::size_t segment = 0;
  for (const std::size_t sample : measurement.row_samples()) {
    while (segment < samples.size() && sample >= samples[segment].second) ++segment;
    const bool inside = segment < samples.size() && sample >= samples[segment].first;
    groups.push_back(inside ? static_cast<int>(segment) : -1);
  }
  return groups;
}

Sequence in_sequence(const std::vector<const MotionSegment*>& segments, const AxisLimits& limits,
                     const Terms& model, double rate_Hz) {
  const double pace = pace_of(limits, model);
  MotionBuilder builder(rate_Hz, segments.front()->start_m);
  Sequence sequence;
  builder.dwell(kSettle_s);
  for (const MotionSegment* segment : segments) {
    builder.move_to(segment->start_m, limits, pace);
    const std::size_t first = builder.size();
    segment->append(builder);
    sequence.samples.emplace_back(first, builder.size());
  }
  builder.dwell(kSettle_s);
  sequence.motion = builder.points();
  return sequence;
}

double friction_level_N(const Terms& terms) {
  double level_N = 0.0;
  for (const Term& term : terms) {
    if (term.effect->has_role(Role::saturating_friction)) level_N += term.gains[0];
    if (term.effect->has_role(Role::hysteresis)) level_N += hysteresis_level_N(term);
  }
  return level_N;
}

}  // namespace slipstack::workbench
