// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/control/reference/fixed_motion.h"

namespace slipstack {

/// Limits of a move, in counts and ticks.
struct MotionLimits {
  float velocity = 0.0F;      ///< counts per tick
  float acceleration = 0.0F;  ///< counts per tick^2, while the speed rises
  float deceleration = 0.0F;  ///< counts per tick^2, while it falls
  float jerk = 0.0F;          ///< counts per tick^3

  /// The narrower of each.
  MotionLimits and_within(const MotionLimits& other) const {
    return {std::min(velocity, other.velocity), std::min(acceleration, other.acceleration),
            std::min(deceleration, other.deceleration), std::min(jerk, other.jerk)};
  }
};

/// Why the arithmetic of the reference cannot represent an axis; refused before anything moves.
enum class ScaleStatus : std::uint8_t {
  kOk,
  kTooFast,  ///< a limit is kLargestRate counts per tick (or tick^2, tick^3) or more: encoder too fine
  kTooSlow,  ///< a limit is less than 2^-32 counts per tick (tick^2, tick^3): encoder too coarse
};

/// Whether the reference can move within these limits.
inline ScaleStatus check_scale(const MotionLimits& limits) {
  for (const float rate : {limits.velocity, limits.acceleration, limits.deceleration, limits.jerk}) {
    if (!(rate < kLargestRate)) return ScaleStatus::kTooFast;
    if (!(rate > 0x1p-32F)) return ScaleStatus::kTooSlow;
  }
  return ScaleStatus::kOk;
}

}  // namespace slipstack
