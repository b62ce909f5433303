// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>

namespace slipstack {

/// The motor current measured last, in A, positive as commanded.
struct CurrentReading {
  float current_A = 0.0F;
  bool valid = true;  ///< false: the converter did not deliver
};

/// Set-point and measurement of the motor current. Called from the tick: never waits. The board converts
/// amperes to its volts or duty cycle and holds the set-point until the next.
template <class M>
concept MotorCurrent = requires(M motor, float current_A) {
  {motor.set(current_A)};                                ///< power stage on, this current from now on
  {motor.disable()};                                     ///< power stage off, zero current
  { motor.measured() } -> std::same_as<CurrentReading>;  ///< the latest complete measurement
};

}  // namespace slipstack
