// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// What holds the controller back at a tick: not faults. Bits of one word.
enum Limit : std::uint16_t {
  kLimitCurrent = 1U << 0,      ///< magnitude of the current (motor and amplifier data sheet)
  kLimitCurrentRate = 1U << 1,  ///< its rate of change (amplifier voltage over motor inductance)
  kLimitReference = 1U << 2,    ///< set-points stopped coming: the axis brakes
  kLimitLevel = 1U << 3,        ///< the adapted friction level is at its bound
};

/// Limits magnitude and rate of the current. 16 instructions.
class CurrentLimit {
 public:
  void reset() { last_A_ = 0.0F; }

  /// The wanted current within both limits; adds to `limits` what applied.
  [[gnu::always_inline]] float step(float largest_A, float largest_step_A, float wanted_A,
                                    std::uint16_t& limits) {
    float current_A = wanted_A;
    if (current_A > largest_A || current_A < -largest_A) {
      limits |= kLimitCurrent;
      current_A = current_A > 0.0F ? largest_A : -largest_A;
    }
    const float step_A = current_A - last_A_;
    if (step_A > largest_step_A || step_A < -largest_step_A) {
      limits |= kLimitCurrentRate;
      current_A = last_A_ + (step_A > 0.0F ? largest_step_A : -largest_step_A);
    }
    last_A_ = current_A;
    return current_A;
  }

  float last_A() const { return last_A_; }

 private:
  float last_A_ = 0.0F;
};

}  // namespace slipstack
