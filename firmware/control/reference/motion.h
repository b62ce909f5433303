// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/reference/braking.h"
#include "firmware/control/reference/fixed_motion.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Where the axis shall be at one tick.
struct ReferencePoint {
  std::int32_t counts = 0;    ///< whole counts
  float fraction = 0.0F;      ///< of a count, 0 to 1
  float velocity = 0.0F;      ///< counts per tick
  float acceleration = 0.0F;  ///< counts per tick^2, mean over the tick that begins here
};

/// What moves, and the segment that moves it. In the unit of MotionSegment.
struct Motion {
  enum class Phase : std::uint8_t { kPlaying, kFollowing, kTracking, kBraking };
  std::int64_t left = 0;  // ticks of the segment
  std::int64_t fraction = 0;
  std::int64_t velocity = 0;
  std::int64_t acceleration = 0;
  std::int64_t jerk = 0;
  std::int32_t shift = 0;
  std::int32_t counts = 0;
  const MotionSegment* next = nullptr;  // of the plan
  const MotionSegment* end = nullptr;
  std::uint32_t taken = 0;  // of the queue
  Phase phase = Phase::kPlaying;

  bool standing() const { return velocity == 0 && acceleration == 0 && left == 0; }
  /// Of a count, 0 to 1.
  float fraction_of_count() const {
    return static_cast<float>(static_cast<std::uint32_t>(fraction >> (kFractionBits - 32))) * 0x1p-32F;
  }

  void begin(const MotionSegment& segment) {
    left = segment.ticks;
    velocity = segment.velocity;
    acceleration = segment.acceleration;
    jerk = segment.jerk;
    shift = segment.shift;
    if (!segment.sets_position) return;
    counts = segment.start_counts;
    fraction = segment.start_fraction;
  }

  /// A stream has ended: a stop begins, with the acceleration that there is. The path of a stream accelerates
  /// so that it can be taken out along the jerk limit below the largest velocity, counts per tick. A
  /// correction of what is off the path may be more: of that only what would carry the reference beyond is
  /// given up at once.
  void leave_stream(const BrakingLimits& limits, float fastest) {
    phase = Phase::kBraking;
    if ((velocity ^ acceleration) < 0) return;
    const float room = fastest - approx::absolute(from_fixed(velocity));
    const float change = approx::absolute(from_fixed(acceleration));
    // The first tick of the stop is one of less acceleration: a - j, a - 2 j and so on add up to this.
    const float fall = limits.curve_jerk;
    if (change * (change - fall) <= 2.0F * fall * room) return;
    if (!(room > 0.0F)) {
      acceleration = 0;
      return;
    }
    // The largest of which that holds, as a share; rounded down.
    constexpr std::int64_t kOne = 4096;
    const float most = 0.5F * fall + approx::fast_square_root(fall * (0.25F * fall + 2.0F * room));
    acceleration = acceleration / kOne * static_cast<std::int32_t>(most / change * static_cast<float>(kOne));
  }

  /// The acceleration of one tick of braking. What is queued while the axis brakes waits for the tick after
  /// it has come to rest.
  void brake(const BrakingLimits& limits) {
    const std::int64_t now = shifted_down(acceleration, shift);
    jerk = 0;
    left = 0;
    shift = 0;
    next = end;
    acceleration = braking_acceleration(velocity, now, limits);
    if (velocity == 0 && acceleration == 0) phase = Phase::kPlaying;
  }

  /// Position now; then moves on by one tick of the segment.
  [[gnu::always_inline]] ReferencePoint step() {
    ReferencePoint point;
    point.counts = counts;
    point.fraction = fraction_of_count();
    acceleration += jerk;
    const std::int64_t increment = shifted_down(acceleration, shift);
    velocity += increment;
    point.acceleration = from_fixed(increment);
    // The step ahead is the mean velocity over the coming tick; half an increment earlier it is that of now.
    point.velocity = from_fixed(velocity) - 0.5F * point.acceleration;
    move();
    if (left != 0) --left;
    return point;
  }

  /// On by the velocity of one tick.
  [[gnu::always_inline]] void move() {
    fraction += velocity;
    counts = sum(counts, static_cast<std::int32_t>(fraction >> kFractionBits));
    fraction &= (std::int64_t{1} << kFractionBits) - 1;
  }
};

}  // namespace slipstack
