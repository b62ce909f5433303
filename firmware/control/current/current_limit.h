// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Limits that are active at a tick; they are no faults. Bits of one word.
enum Limit : std::uint16_t {
  kLimitCurrent = 1U << 0,      ///< magnitude of the current (motor and amplifier data sheet)
  kLimitCurrentRate = 1U << 1,  ///< its rate of change (amplifier voltage over motor inductance)
  kLimitReference = 1U << 2,    ///< the axis brakes: a stop, or set-points stopped coming
  kLimitPosition = 1U << 3,     ///< an end of the position range holds the axis back
  kLimitSwitch = 1U << 5,       ///< a limit switch is active
  kLimitVelocity = 1U << 4,     ///< the velocity limit takes force away in torque mode
};

/// Limits magnitude and rate of the current, also of one that is not a number.
class CurrentLimit {
 public:
  void reset() { last_A_ = 0.0F; }

  /// The wanted current within both limits; adds to `limits` what applied.
  float step(float largest_A, float largest_step_A, float wanted_A, std::uint16_t& limits) {
    float current_A = wanted_A;
    if (beyond(current_A, largest_A)) {
      limits |= kLimitCurrent;
      current_A = current_A > 0.0F ? largest_A : -largest_A;
    }
    const float step_A = current_A - last_A_;
    if (beyond(step_A, largest_step_A)) {
      limits |= kLimitCurrentRate;
      current_A = last_A_ + (step_A > 0.0F ? largest_step_A : -largest_step_A);
    }
    last_A_ = current_A;
    return current_A;
  }

  float last_A() const { return last_A_; }

 private:
  // True for NaN.
  static bool beyond(float value, float limit) { return !(approx::absolute(value) <= limit); }

  float last_A_ = 0.0F;
};

}  // namespace slipstack
