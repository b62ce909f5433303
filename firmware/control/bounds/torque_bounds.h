// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/current/current_limit.h"
#include "firmware/control/parameters/control_set.h"

namespace slipstack {

/// What bounds an axis whose force is commanded: its velocity, and the ends of its travel. Towards an end it
/// is held, which means that it is braked and then keeps its place, until the force points away from there.
class TorqueBounds {
 public:
  /// The force fades to zero towards the largest velocity, and brakes beyond it, as the velocity loop does.
  static float within_velocity(const ControlSet& set, float largest_mps, float velocity_mps, float target_N,
                               std::uint16_t& limits) {
    const float gain = set.feedback.velocity_N_s_per_m;
    const float limited_N =
        approx::clamp(target_N, gain * (-largest_mps - velocity_mps), gain * (largest_mps - velocity_mps));
    if (gain == 0.0F || limited_N == target_N) return target_N;
    limits |= kLimitVelocity;
    return limited_N;
  }

  /// How the axis moves, in counts and ticks, and what pushes it.
  struct Motion {
    std::int32_t counts;
    float velocity;
    float acceleration;
    float force_N;
  };
  /// Holds the axis if it must be braked from the next tick on to rest within the range, or stands at an end
  /// and is pushed out.
  void look_ahead(const PositionRange& range, const StoppingDistanceBound& stopping, const Motion& motion) {
    const float speed = approx::absolute(motion.velocity);
    const bool forward = (speed >= 1.0F ? motion.velocity : motion.force_N) > 0.0F;
    const float room = range.room(motion.counts, forward);
    const float outwards = forward ? motion.acceleration : -motion.acceleration;
    // Three ticks: that of the estimate, this one, and the one that brakes.
    const float needed = stopping.from(speed, outwards > 0.0F ? outwards : 0.0F) + 3.0F * speed;
    const bool inside = room > needed || (speed < 1.0F && motion.force_N == 0.0F);
    held_ = static_cast<std::int8_t>(inside ? 0 : (forward ? 1 : -1));
  }

  bool holds() const { return held_ != 0; }
  /// The force points away from the end.
  bool pulled_inwards(float force_N) const { return static_cast<float>(held_) * force_N <= 0.0F; }
  void release() { held_ = 0; }

 private:
  std::int8_t held_ = 0;  // at which end
};

}  // namespace slipstack
