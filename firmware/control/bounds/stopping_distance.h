// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// The stopping distance along the limits of deceleration d and jerk j, from any velocity and acceleration;
/// signed.
///
/// With t = a / j, the stop is the same as one that began t later (or earlier, a < 0) with v1 = v + a t / 2
/// and no acceleration, plus the way between, t (v1 - a t / 6). From v1 it takes v1^2 / 2d + v1 d / 2j, or
/// v1 sqrt(v1 / j) where d is not reached. In the main loop; a square root and four divisions.
class StoppingDistance {
 public:
  /// Both > 0.
  StoppingDistance(float deceleration, float jerk) : deceleration_(deceleration), jerk_(jerk) {}

  float operator()(float velocity, float acceleration) const {
    // The velocity that is left when the acceleration has been taken out says where the axis goes.
    const float gained = 0.5F * acceleration * acceleration / jerk_;
    const float left = velocity + (acceleration < 0.0F ? -gained : gained);
    return left < 0.0F ? -forward(-velocity, -acceleration, gained) : forward(velocity, acceleration, gained);
  }

 private:
  float forward(float velocity, float acceleration, float gained) const {
    const float ticks = acceleration / jerk_;
    const float peak = velocity + gained;
    return from_steady(peak) + ticks * (peak - gained * (1.0F / 3.0F));
  }
  float from_steady(float velocity) const {
    if (velocity * jerk_ < deceleration_ * deceleration_) {
      return velocity > 0.0F ? velocity * approx::fast_square_root(velocity / jerk_) : 0.0F;
    }
    return 0.5F * velocity * (velocity / deceleration_ + deceleration_ / jerk_);
  }

  float deceleration_;
  float jerk_;
};

}  // namespace slipstack
