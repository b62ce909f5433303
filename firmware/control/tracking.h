// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/fixed_motion.h"
#include "firmware/effects/approx.h"

namespace slipstack {

/// A place that moves, at the end of the tick that begins.
struct StreamPoint {
  std::int32_t counts = 0;
  std::uint32_t fraction = 0;  ///< of a count x 2^-32
  std::int64_t step = 0;       ///< how far it moves in this tick, fixed point
};

/// Within what the reference follows a stream, fixed point, counts and ticks.
struct TrackingLimits {
  std::int64_t velocity = 0;
  std::int64_t acceleration = 0;
  std::int64_t approach = 0;  ///< acceleration with which an error is made up for
  float approach_counts = 0.0F;
};

/// Outside the tick.
inline TrackingLimits tracking_limits(float counts_per_tick, float counts_per_tick2) {
  TrackingLimits limits;
  limits.velocity = to_fixed(counts_per_tick) + 1;
  limits.acceleration = to_fixed(counts_per_tick2) + 1;
  // The stream may accelerate meanwhile, and the law below decelerates by up to 9/8 of its value.
  limits.approach_counts = 0.5F * counts_per_tick2;
  limits.approach = to_fixed(limits.approach_counts) + 1;
  return limits;
}

/// The step of the reference in this tick on its way to a stream, from its step in the last one: never faster
/// than the velocity limit, never another step than the last by more than the acceleration limit, whatever
/// the stream does. `error`: stream less reference at the begin of the tick. On the stream, and while it
/// stays within the limits, the step is exactly the stream's.
///
/// The relative velocity d towards a place e away, decelerating by a in every tick:
/// d = sqrt(2 a e + a^2 / 4) - a / 2 returns itself less a in the next tick, since e = d (d + a) / 2a; within
/// a the rest is made in one tick. That is the time-optimal discrete double integrator, with its linear zone
/// (Zanasi, Guarino Lo Bianco, Tonielli, Automatica 36 (2000), 439-448). In the tick.
inline std::int64_t tracking_step(std::int64_t error, std::int64_t stream_step, std::int64_t last_step,
                                  const TrackingLimits& limits) {
  std::int64_t towards = error;
  if (error > limits.approach || error < -limits.approach) {
    const float a = limits.approach_counts;
    const float distance = approx::absolute(from_fixed(error));
    const float counts = approx::fast_square_root(a * (2.0F * distance + 0.25F * a)) - 0.5F * a;
    const auto wanted = static_cast<std::int64_t>(
                            static_cast<std::int32_t>(approx::clamp(counts, 0.0F, kLargestRate) * 0x1p12F))
                        << (kFractionBits - 12);
    towards = error > 0 ? wanted : -wanted;
  }
  const auto within = [](std::int64_t value, std::int64_t low, std::int64_t high) {
    return value < low ? low : (value > high ? high : value);
  };
  const std::int64_t step = within(stream_step + towards, -limits.velocity, limits.velocity);
  return within(step, last_step - limits.acceleration, last_step + limits.acceleration);
}

}  // namespace slipstack
