// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack {

/// Volts at a converter's pin.
struct AnalogueReading {
  float volts = 0.0F;
  bool valid = false;  ///< false: there is no such input, or it is at a rail, as with a broken wire
};

/// The slow analogue inputs of a board that has them; what a volt stands for is a parameter of the axis.
/// Used outside the tick; no call waits. A board may have only one of them.
class AnalogueInputs {
 public:
  virtual bool has_temperature() const = 0;
  virtual bool has_bus_voltage() const = 0;
  /// Of the motor's winding; the latest conversion, at most 1 ms old.
  virtual AnalogueReading temperature() = 0;
  /// Of the amplifier's DC link.
  virtual AnalogueReading bus_voltage() = 0;

 protected:
  ~AnalogueInputs() = default;
};

}  // namespace slipstack
