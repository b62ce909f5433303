// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// What the controller publishes after each tick.
struct ControlOutput {
  float current_A = 0.0F;
  bool driving = false;      ///< false: power stage off
  std::uint16_t limits = 0;  ///< bits of Limit
  std::int32_t reference_counts = 0;
  float position_error_m = 0.0F;  ///< reference less estimate
  float velocity_mps = 0.0F;      ///< estimated
  float feedforward_N = 0.0F;     ///< model on the reference, level included; in torque mode not applied
  float feedback_N = 0.0F;        ///< in position mode only
  float residual_N = 0.0F;        ///< force that the model misses, from the disturbance observer
  float level = 1.0F;             ///< adapted friction level
};

/// What the tick does with the motor.
enum class ControlMode : std::uint8_t {
  kOff,       ///< power stage off; the reference lies where the axis is
  kPosition,  ///< the axis follows the reference; also while it is braked under control
  kTorque,    ///< the force is commanded; the reference follows the axis
  kPush,      ///< the force is that of the direction check, before operation is enabled
};

}  // namespace slipstack
