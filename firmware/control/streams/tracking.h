// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// A place that moves, in counts and ticks.
struct StreamPoint {
  std::int32_t counts = 0;
  float offset = 0.0F;  ///< from there to where it is at the end of the tick that begins
  float step = 0.0F;    ///< how far it moves in this tick
};

/// The velocity towards a place that is `error` away, of a proximate time-optimal servomechanism: what a
/// constant deceleration takes to zero, sqrt(2 a e), with a linear zone where the error is small, joined with
/// the same slope (Workman, Kosut, Franklin, Adaptive proximate time-optimal servomechanisms: continuous time
/// case, American Control Conference 1987, 589-594). `share`: of a small error, made up for in a unit of
/// time; `linear`: a / share^2, up to where it is small.
[[gnu::always_inline]] inline float approach_velocity(float error, float share, float linear,
                                                      float half_linear, float twice_deceleration) {
  const float distance = approx::absolute(error);
  if (!(distance > linear)) return share * error;
  const float velocity = approx::fast_square_root(twice_deceleration * (distance - half_linear));
  return error > 0.0F ? velocity : -velocity;
}

/// Within what the reference follows a stream, counts and ticks.
struct TrackingLimits {
  /// Share of an error that is made up for in a tick: a time constant of 32 ticks, short against the periods
  /// of a bus with its two or three set-points of delay, and long enough that the last bit of a float, 10^-3
  /// count 20 mm away, is no force: at counts of 1 um and 10 kHz 6 10^-3 m/s2.
  static constexpr float kShare = 1.0F / 32.0F;

  float velocity = 0.0F;
  float acceleration = 0.0F;
  float linear = 0.0F;  ///< error up to which kShare of it is made up for in a tick
  float half_linear = 0.0F;
  float twice_approach = 0.0F;  ///< acceleration with which a larger one is made up for

  static TrackingLimits of(float counts_per_tick, float counts_per_tick2) {
    // Half of it: the stream accelerates too.
    const float approach = 0.5F * counts_per_tick2;
    const float linear = approach / (kShare * kShare);
    return {counts_per_tick, counts_per_tick2, linear, 0.5F * linear, 2.0F * approach};
  }
  /// Behind a path that keeps these limits in periods of a clock that is faster by up to `clock_range`: as
  /// much more, and the last bit of a step. Without it a path at its limit would leave the reference behind,
  /// by that bit in every tick, which is then made up for without regard to jerk (250 m/s3 at 0.24 m/s after
  /// 100 ticks of 5 m/s2, counts of 1 um at 10 kHz).
  static TrackingLimits of_path(float counts_per_tick, float counts_per_tick2, float clock_range) {
    return of(counts_per_tick * (1.0F + clock_range),
              counts_per_tick2 * (1.0F + 2.0F * clock_range) + counts_per_tick * 0x1p-23F);
  }
};

/// The step of the reference in this tick on its way to a stream, from its step in the last one: never faster
/// than the velocity limit, never another step than the last by more than the acceleration limit, whatever
/// the stream does. `error`: stream less reference at the begin of the tick. While the stream stays within
/// the limits and the error is zero, the step is the stream's. `last_change`: of the step, in the last tick;
/// where that was beyond the acceleration limit, as in a stop that is harder than the stream may be, as much
/// is allowed again, that way only. In the tick.
[[gnu::always_inline]] inline float tracking_step(float error, float stream_step, float last_step,
                                                  float last_change, const TrackingLimits& limits) {
  const float towards = approach_velocity(error, TrackingLimits::kShare, limits.linear, limits.half_linear,
                                          limits.twice_approach);
  const float step = approx::clamp(stream_step + towards, -limits.velocity, limits.velocity);
  const float up = last_change > limits.acceleration ? last_change : limits.acceleration;
  const float down = last_change < -limits.acceleration ? last_change : -limits.acceleration;
  return approx::clamp(step, last_step + down, last_step + up);
}

}  // namespace slipstack
