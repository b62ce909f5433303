// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/force/notch.h"
#include "firmware/control/force/state_estimate.h"
#include "firmware/control/reference/reference.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Position P, velocity PI, two notches:
///
///   F = notch(notch(p + i)),  p = Kv (v_ref + Kp e - v),  i' = Ki (p + F_applied - F_wanted)
///
/// with the integral held back by what the limits of the current took away (docs/control.md).
class Feedback {
 public:
  /// Constants of the tick; made outside it.
  struct Gains {
    float resolution_m = 1.0F;
    float mps_per_count = 0.0F;
    float position_per_s = 0.0F;
    float velocity_N_s_per_m = 0.0F;
    float integral_per_tick = 0.0F;
    std::array<Notch::Gains, 2> notch;
  };

  /// Position of the reference less that of the estimate.
  static float error_m(const Gains& gain, const ReferencePoint& at, const StateEstimate& estimate) {
    const float counts = static_cast<float>(difference(at.counts, estimate.counts())) + at.fraction;
    return counts * gain.resolution_m - estimate.offset_m();
  }

  /// One tick: the force in N from the reference, the position error and the estimated velocity.
  float step(const Gains& gain, const ReferencePoint& at, float error_m, float velocity_mps) {
    const float wanted_mps = at.velocity * gain.mps_per_count + gain.position_per_s * error_m;
    proportional_N_ = gain.velocity_N_s_per_m * (wanted_mps - velocity_mps);
    return notch_[1].step(gain.notch[1], notch_[0].step(gain.notch[0], proportional_N_ + integral_N_));
  }

  /// Behind the limits: the force that was applied and the one that was wanted, both N.
  void integrate(const Gains& gain, float applied_N, float wanted_N) {
    integral_N_ += gain.integral_per_tick * (proportional_N_ + applied_N - wanted_N);
  }

  /// The feed-forward makes this force from now on, N.
  void give_up(float force_N) { integral_N_ -= force_N; }

  /// Forgets the past.
  void reset() {
    integral_N_ = 0.0F;
    proportional_N_ = 0.0F;
    for (Notch& notch : notch_) notch.reset();
  }

 private:
  std::array<Notch, 2> notch_;
  float integral_N_ = 0.0F;
  float proportional_N_ = 0.0F;
};

}  // namespace slipstack
