// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/control/parameters/parameters.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Load of one part by the square of its current, as a share of what it bears for ever:
///
///   load' = ((I / rated)^2 - load) / time constant
///
/// A body of one heat capacity; after a reset it is taken for warm, since nothing tells how long the power
/// was off: IEC 61800-5-1 wants the thermal memory kept, or a start that is as safe.
class ThermalLoad {
 public:
  static constexpr float kAfterReset = 0.9F;

  void step(float elapsed_s, float current_A, float rated_A, float time_constant_s) {
    const float ratio = rated_A > 0.0F ? current_A / rated_A : 0.0F;
    const float share = approx::clamp(elapsed_s / time_constant_s, 0.0F, 1.0F);
    const float next = load_ + share * (ratio * ratio - load_);
    if (approx::is_finite(next)) load_ = next;
  }
  float load() const { return load_; }

  /// From the peak current down to the rated one, while the load rises from 90 % to 100 %: without a step,
  /// and without a limit that switches on and off. A rating of 0 is none.
  float limit_A(float peak_A, float rated_A) const {
    if (!(rated_A > 0.0F) || rated_A >= peak_A) return peak_A;
    const float spent = approx::clamp((load_ - kAfterReset) / (1.0F - kAfterReset), 0.0F, 1.0F);
    return peak_A - spent * (peak_A - rated_A);
  }

 private:
  float load_ = kAfterReset;
};

/// I2t of motor and amplifier. In the main loop; what it leaves of the current limit goes to the tick.
class ThermalLimit {
 public:
  void step(const AxisParameters& axis, float elapsed_s, float current_A) {
    motor_.step(elapsed_s, current_A, axis.motor_rated_A, axis.motor_thermal_s);
    amplifier_.step(elapsed_s, current_A, axis.amplifier_rated_A, axis.amplifier_thermal_s);
    limit_A_ = motor_.limit_A(axis.current_limit_A, axis.motor_rated_A);
    const float amplifier_A = amplifier_.limit_A(axis.current_limit_A, axis.amplifier_rated_A);
    if (amplifier_A < limit_A_) limit_A_ = amplifier_A;
    reduces_ = limit_A_ < axis.current_limit_A;
    spent_ = reduces_ && (motor_.load() >= kSpent || amplifier_.load() >= kSpent);
  }

  float limit_A() const { return limit_A_; }
  bool reduces() const { return reduces_; }
  /// Nothing is left above the rated current. At the rated current the load comes near 1 and never beyond.
  bool spent() const { return spent_; }
  float motor_load() const { return motor_.load(); }
  float amplifier_load() const { return amplifier_.load(); }

 private:
  static constexpr float kSpent = 0.999F;
  ThermalLoad motor_;
  ThermalLoad amplifier_;
  float limit_A_ = 0.0F;
  bool reduces_ = false;
  bool spent_ = false;
};

}  // namespace slipstack
