// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack {

/// How the machine's signals stand for counts and amperes. The defaults are an amplifier of 1 A/V and a
/// current monitor of 0.1 V/A around the middle of the converter.
struct SignalScales {
  bool encoder_reversed = false;
  bool motor_reversed = false;    ///< command and monitor change their signs
  float command_A_per_V = 1.0F;   ///< motor current per volt of the amplifier's command
  float command_zero_V = 0.0F;    ///< the command at which no current flows
  float monitor_A_per_V = 10.0F;  ///< motor current per volt at the converter's pin
  float monitor_zero_V = 1.65F;   ///< there, without current
};

/// The conversions of a board's encoder and motor current. Used outside the tick, while the controller has no
/// parameters: readings may step. The tick pays nothing for it.
class SignalScaling {
 public:
  virtual void set_scales(const SignalScales& scales) = 0;
  /// The largest current that the command can ask for with these scales, A.
  virtual float largest_A(const SignalScales& scales) const = 0;

 protected:
  ~SignalScaling() = default;
};

/// Of an amplifier with a command of +-10 V.
constexpr float largest_of_10_V(const SignalScales& scales) {
  const float zero_V = scales.command_zero_V < 0.0F ? -scales.command_zero_V : scales.command_zero_V;
  return scales.command_A_per_V * (10.0F - zero_V);
}

}  // namespace slipstack
