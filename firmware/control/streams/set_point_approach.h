// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/streams/set_point_spline.h"
#include "firmware/control/streams/tracking.h"
#include "firmware/control/streams/velocity_spline.h"
#include "firmware/effects/approx.h"

namespace slipstack {

/// From the state that the reference is in to the spline of a stream that begins somewhere else, as fast as
/// another: a path of the same kind (velocity_spline.h) whose control points approach those of the spline.
/// Acceleration is continuous on the way, so that no force steps; once the control points are the same, so
/// are the segments.
///
/// A period's step is that of the spline and what a proximate time-optimal servomechanism takes off the
/// distance (tracking.h), with half of the acceleration; the other half is the spline's. Outside the tick.
class SetPointApproach {
 public:
  /// `path` has begun, and has its limits; `acceleration`: of these, counts per period^2.
  SetPointApproach(SetPointSpline& spline, VelocitySpline& path, float acceleration)
      : spline_(spline), path_(path), acceleration_(0.5F * acceleration) {}

  void extrapolate(std::uint32_t period, std::int32_t largest_bend) {
    static_cast<void>(spline_.extrapolate(period, largest_bend));
  }
  StreamSegment segment(std::uint32_t period, std::int32_t largest_bend) {
    static_cast<void>(spline_.segment(period, largest_bend));
    const float step = spline_.step(period);
    path_.put(period, step + towards(distance(period - 1)));
    return path_.segment(period, largest_bend);
  }
  /// The path has met the spline at the control point of this period.
  bool meets(std::uint32_t period) const { return approx::absolute(distance(period)) < kMet_counts; }

 private:
  static constexpr float kMet_counts = 0.125F;  ///< a sixth of a count is what the spline rounds to
  static constexpr float kShare = 0.25F;        ///< of a small distance, in a period

  float distance(std::uint32_t period) const {
    return spline_.beyond(period, path_.counts(period)) - path_.fraction(period);
  }
  float towards(float distance) const {
    const float linear = acceleration_ / (kShare * kShare);
    return approach_velocity(distance, kShare, linear, 0.5F * linear, 2.0F * acceleration_);
  }

  SetPointSpline& spline_;
  VelocitySpline& path_;
  float acceleration_;
};

}  // namespace slipstack
