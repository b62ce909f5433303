// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace slipstack {

/// Where the axis may be, both ends included; counts. An end that is the last count there is does not bound.
struct PositionRange {
  static constexpr std::int32_t kNoLowest = std::numeric_limits<std::int32_t>::min();
  static constexpr std::int32_t kNoHighest = std::numeric_limits<std::int32_t>::max();
  std::int32_t lowest = kNoLowest;
  std::int32_t highest = kNoHighest;

  /// What both allow.
  PositionRange and_within(const PositionRange& other) const {
    return {lowest > other.lowest ? lowest : other.lowest, highest < other.highest ? highest : other.highest};
  }
  /// The place in it that is nearest to `counts`.
  std::int32_t nearest(std::int32_t counts) const {
    return static_cast<std::int32_t>(nearest(std::int64_t{counts}));
  }
  /// The same for any number: beyond the last count only where the range has no end there.
  std::int64_t nearest(std::int64_t counts) const {
    if (counts < lowest && lowest != kNoLowest) return lowest;
    return counts > highest && highest != kNoHighest ? highest : counts;
  }
  /// Counts that are left in one direction, 0 if there are none.
  float room(std::int32_t counts, bool forward) const {
    if (forward ? highest == kNoHighest : lowest == kNoLowest) return 0x1p32F;
    const std::int32_t further = forward ? highest : counts;
    const std::int32_t nearer = forward ? counts : lowest;
    if (further <= nearer) return 0.0F;
    return static_cast<float>(static_cast<std::uint32_t>(further) - static_cast<std::uint32_t>(nearer));
  }
};

/// An upper bound of the stopping distance by braking_acceleration(), in counts.
///
/// From velocity v and acceleration a: with t = a / j, the stop is the same as one that began t ticks later
/// (or earlier, a < 0) with v1 = v + a t / 2 and no acceleration, plus the way between, t (v1 - a t / 6).
/// From v1 the stop with full deceleration d takes v1^2 / 2d + v1 d / 2j, and a shorter one, v1 sqrt(v1 / j),
/// less.
struct StoppingDistanceBound {
  float per_velocity2 = 0.0F;  // 1 / 2d
  float per_velocity = 0.0F;   // d / 2j
  float per_jerk = 0.0F;       // 1 / j

  static StoppingDistanceBound of(float deceleration, float jerk) {
    return {0.5F / deceleration, 0.5F * deceleration / jerk, 1.0F / jerk};
  }
  /// Both towards the same side, counts per tick and per tick^2; velocity >= 0.
  float from(float velocity, float acceleration) const {
    const float ticks = acceleration * per_jerk;
    const float gained = acceleration * ticks;
    const float peak = velocity + 0.5F * gained;
    return peak * (peak * per_velocity2 + per_velocity) + ticks * (peak - gained * (1.0F / 6.0F));
  }
};

}  // namespace slipstack
