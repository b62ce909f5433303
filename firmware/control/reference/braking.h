// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/reference/fixed_motion.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// How the reference comes to rest: deceleration and jerk of every stop, as the tick uses them.
struct BrakingLimits {
  std::int64_t deceleration = 0;  ///< counts per tick^2 x 2^-44
  std::int64_t jerk = 0;          ///< counts per tick^3 x 2^-44, > 0
  float deceleration_counts = 0.0F;
  float curve_jerk = 1.0F;      ///< of the switching curve, counts per tick^3
  float eight_per_jerk = 8.0F;  ///< 8 / curve_jerk
  float grid = 1.0F;            ///< accelerations are rounded to 1 / grid counts per tick^2, a power of two,
  std::uint64_t grid_unit = 1;  ///< which is this much in the unit of the fixed point
};

/// Outside the tick; both positive and at most kLargestRate.
inline BrakingLimits braking_limits(float counts_per_tick2, float counts_per_tick3) {
  BrakingLimits limits;
  limits.deceleration = to_fixed(counts_per_tick2) + 1;
  limits.jerk = to_fixed(counts_per_tick3) + 1;
  limits.deceleration_counts = counts_per_tick2;
  // A thousandth below the limit, so that what rounding takes the motion off the curve is regained on the
  // way.
  limits.curve_jerk = counts_per_tick3 * (1.0F - 0x1p-10F);
  limits.eight_per_jerk = 8.0F / limits.curve_jerk;
  int bits = 30;  // of the grid; what it rounds fits 31 bits
  for (float largest = counts_per_tick2; largest >= 1.0F && bits > 0; largest *= 0.5F) --bits;
  limits.grid = approx::power_of_two<float>(bits);
  limits.grid_unit = std::uint64_t{1} << (kFractionBits - bits);
  return limits;
}

/// The acceleration of the next tick that stops fastest, from any velocity and acceleration: the
/// velocity then changes by it. Jerk never exceeds its limit, deceleration only where it did before.
/// Velocity and acceleration end at exactly zero, both in the same tick or one after the other.
///
/// From acceleration -k jerk and velocity k (k + 1) / 2 jerk, k ticks of full jerk lead to rest. Between
/// whole k that curve is continued by straight lines, v / (k + 1) + k jerk / 2, on which the jerk stays at
/// its limit and the last two ticks end in zero (Han, From PID to Active Disturbance Rejection Control, IEEE
/// Trans. Ind. Electron. 56 (2009), section III.A, has this construction for a given final position). The
/// curve is approached at full jerk and joined at the deceleration limit. In the tick; one square root, one
/// division.
inline std::int64_t braking_acceleration(std::int64_t velocity, std::int64_t acceleration,
                                         const BrakingLimits& limits) {
  const std::int64_t speed = velocity < 0 ? -velocity : velocity;
  std::int64_t wanted = speed;
  if (speed > limits.jerk) {
    const float counts = from_fixed(speed);
    const float root = approx::fast_square_root(1.0F + counts * limits.eight_per_jerk);
    const auto k = static_cast<float>(static_cast<std::int32_t>(0.5F * root - 0.5F));
    float deceleration = counts / (k + 1.0F) + 0.5F * k * limits.curve_jerk;
    if (deceleration > limits.deceleration_counts) deceleration = limits.deceleration_counts;
    // A product, since a shift of 64 bits by a variable takes five times the instructions.
    wanted =
        static_cast<std::int64_t>(static_cast<std::uint32_t>(deceleration * limits.grid) * limits.grid_unit);
  }
  const std::int64_t change = (velocity < 0 ? wanted : -wanted) - acceleration;
  if (change > limits.jerk) return acceleration + limits.jerk;
  if (change < -limits.jerk) return acceleration - limits.jerk;
  return acceleration + change;
}

}  // namespace slipstack
