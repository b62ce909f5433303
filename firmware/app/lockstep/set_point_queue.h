// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/bounds/stopping_distance.h"
#include "firmware/control/reference/motion_limits.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/streams/uniform_spline.h"

namespace slipstack {

/// Set-points that are there before they are needed, one every `period` ticks, joined by a uniform cubic
/// B-spline (uniform_spline.h): segments of the reference's queue, exact to 2^-44 of a count. The control
/// points are c = p - (p_next - 2 p + p_before) / 6; the spline passes the set-points to within a 36th of
/// their fourth difference. Three periods of delay: after the last set-point, send it three times more.
///
/// What a master sends by SYNC is another matter: CyclicPosition locks to its clock and bridges what is
/// missing.
class SetPointQueue {
 public:
  static constexpr std::int32_t kLongestPeriod = 100;

  /// What the motion keeps within, counts and ticks.
  struct Bounds {
    MotionLimits motion;
    float stop_deceleration = 0.0F;  ///< of the stop that follows when set-points fail to come
    PositionRange range;
  };

  /// Starts from rest at the generator's position; a set-point every 1 to kLongestPeriod ticks.
  void start(const ReferenceGenerator& generator, std::int32_t period_ticks) {
    origin_ = generator.counts();
    last_ = before_ = 0;
    control_ = {};
    period_ = period_ticks < 1 ? 1 : (period_ticks > kLongestPeriod ? kLongestPeriod : period_ticks);
  }

  /// Takes a set-point, counts and a fraction of 2^-32, and queues a segment of one period. False when there
  /// is no room, or the motion would leave its bounds: in the segment, or in a stop behind it. Then no more
  /// is queued, and the reference brakes. Outside the tick.
  bool push(ReferenceGenerator& generator, const Bounds& bounds, std::int32_t counts,
            std::uint32_t fraction = 0) {
    const std::int64_t n = period_;
    // 2^32 per count: what is lost is below 10^-4 count after the longest period, and products fit.
    const std::int64_t next =
        static_cast<std::int64_t>(difference(counts, origin_)) * kUnit + static_cast<std::int64_t>(fraction);
    const std::int64_t largest = n * (kUnit << 18);
    if (generator.free() == 0 || next - last_ >= largest || next - last_ <= -largest) return false;
    const std::int64_t newest = last_ - (next - 2 * last_ + before_) / 6;
    const auto [c0, c1, c2] = control_;
    // The cubic x0 + V m + A m^2 / 2 + J m^3 / 6 over ticks m, and the sums of the generator that pass
    // through it.
    const auto spline = SplineSegment<std::int64_t>::of(c0, c1, c2, newest);
    if (!within(bounds, {c0, c1, c2, newest})) return false;
    const std::int64_t jerk = spline.twist / (n * n * n);
    const std::int64_t acceleration = spline.bend / (n * n);
    const std::int64_t velocity = spline.twice_slope / (2 * n);
    const std::int64_t start = spline.sixfold / 6;
    constexpr std::int64_t kFine = std::int64_t{1} << (kFractionBits - kUnitBits);
    const MotionSegment segment{.ticks = period_,
                                .start_counts = sum(origin_, static_cast<std::int32_t>(start >> kUnitBits)),
                                .start_fraction = (start & (kUnit - 1)) * kFine,
                                .velocity = (velocity - acceleration / 2 + jerk / 6) * kFine,
                                .acceleration = (acceleration - jerk) * kFine,
                                .jerk = jerk * kFine,
                                .sets_position = true};
    if (!generator.push(segment)) return false;
    // The origin follows, so that differences stay small however far the stream goes.
    const auto moved = static_cast<std::int32_t>(last_ >> kUnitBits);
    const std::int64_t shift = moved * kUnit;
    origin_ = sum(origin_, moved);
    control_ = {c1 - shift, c2 - shift, newest - shift};
    before_ = last_ - shift;
    last_ = next - shift;
    return true;
  }

 private:
  static constexpr int kUnitBits = 32;
  static constexpr std::int64_t kUnit = std::int64_t{1} << kUnitBits;

  // A spline's velocity, acceleration and jerk lie between the differences of its control points; a
  // thousandth is left to rounding. It ends behind the third, with the last two accelerations' velocity.
  bool within(const Bounds& bounds, const std::array<std::int64_t, 4>& control) const {
    const auto ticks = static_cast<float>(period_);
    std::array<float, 3> velocity{};
    for (std::size_t i = 0; i < 3; ++i)
      velocity[i] = static_cast<float>(control[i + 1] - control[i]) * 0x1p-32F / ticks;
    const float before = (velocity[1] - velocity[0]) / ticks;
    const float after = (velocity[2] - velocity[1]) / ticks;
    const MotionLimits& limits = bounds.motion;
    constexpr float kMost = 1.001F;
    bool inside = approx::absolute(after - before) <= kMost * limits.jerk * ticks;
    for (const float one : velocity) inside = inside && approx::absolute(one) <= kMost * limits.velocity;
    for (const float one : {before, after})
      inside = inside && approx::absolute(one) <= kMost * limits.acceleration;
    const float last = 0.5F * (velocity[1] + velocity[2]);
    // The spline ends beside its control point by a sixth of the bend there.
    const float stop = StoppingDistance(bounds.stop_deceleration, limits.jerk)(last, after) +
                       after * ticks * ticks * (1.0F / 6.0F);
    const std::int32_t end = sum(origin_, static_cast<std::int32_t>(control[2] >> kUnitBits));
    const bool forward = stop > 0.0F;
    return inside && (stop == 0.0F || approx::absolute(stop) <= bounds.range.room(end, forward));
  }

  std::int32_t origin_ = 0;
  std::int32_t period_ = 1;
  std::int64_t before_ = 0;  // set-points, relative to the origin
  std::int64_t last_ = 0;
  std::array<std::int64_t, 3> control_{};  // oldest first
};

}  // namespace slipstack
