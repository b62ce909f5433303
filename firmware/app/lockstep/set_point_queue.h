// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

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

  /// Starts from rest at the generator's position; a set-point every 1 to kLongestPeriod ticks.
  void start(const ReferenceGenerator& generator, std::int32_t period_ticks) {
    origin_ = generator.counts();
    last_ = before_ = 0;
    control_ = {};
    period_ = period_ticks < 1 ? 1 : (period_ticks > kLongestPeriod ? kLongestPeriod : period_ticks);
  }

  /// Takes a set-point, counts and a fraction of 2^-32, and queues a segment of one period. False when there
  /// is no room or the set-points lie kLargestRate counts per tick or more apart. Outside the tick.
  bool push(ReferenceGenerator& generator, std::int32_t counts, std::uint32_t fraction = 0) {
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

  std::int32_t origin_ = 0;
  std::int32_t period_ = 1;
  std::int64_t before_ = 0;  // set-points, relative to the origin
  std::int64_t last_ = 0;
  std::array<std::int64_t, 3> control_{};  // oldest first
};

}  // namespace slipstack
