// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/parameters/parameters.h"
#include "firmware/control/supervision/faults.h"
#include "hal/include/analogue_inputs.h"

namespace slipstack {

/// What the analogue inputs of the board say.
struct AnalogueReadings {
  AnalogueReading temperature;
  AnalogueReading bus;
};

/// Temperature of the motor and voltage of the amplifier's DC link against their limits, by samples in the
/// main loop. A signal whose gain is 0 is not wired and never limits.
class AnalogueWatch {
 public:
  /// In every pass of the main loop: the fault that there is now, kNone if there is none. `driving`: current
  /// flows; only then a low voltage is one, for without the motor's supply the drive just cannot be enabled.
  Fault step(const AxisParameters& axis, const AnalogueReadings& in, float elapsed_s, bool driving) {
    const bool has_temperature = axis.temperature_C_per_V != 0.0F;
    const bool has_bus = axis.bus_V_per_V != 0.0F;
    temperature_C_ = axis.temperature_C_per_V * in.temperature.volts + axis.temperature_at_zero_C;
    bus_V_ = axis.bus_V_per_V * in.bus.volts;
    const bool warm = has_temperature && in.temperature.valid;
    warns_ = warm && temperature_C_ > axis.temperature_warning_C;
    const bool hot = hot_.step(warm && temperature_C_ > axis.temperature_fault_C, elapsed_s, kTemperature_s);
    const bool known = has_bus && in.bus.valid;
    low_now_ = known && bus_V_ < axis.bus_lowest_V;
    const bool low = low_.step(low_now_, elapsed_s, kVoltage_s);
    const bool high = high_.step(known && bus_V_ > axis.bus_highest_V, elapsed_s, kVoltage_s);
    const bool broken = (has_temperature && !in.temperature.valid) || (has_bus && !in.bus.valid);
    const bool lost = lost_.step(broken, elapsed_s, kSensor_s);
    if (high) return Fault::kOverVoltage;
    if (low && driving) return Fault::kUnderVoltage;
    if (hot) return Fault::kOverTemperature;
    return lost ? Fault::kAnalogueSensor : Fault::kNone;
  }

  // As of the last step.
  float temperature_C() const { return temperature_C_; }
  float bus_V() const { return bus_V_; }
  bool warns() const { return warns_; }
  /// The DC link has no voltage to drive with.
  bool bus_low() const { return low_now_; }

 private:
  // Ripple and dips of a rectified supply last some milliseconds less; a winding takes seconds.
  static constexpr float kVoltage_s = 2.0e-3F;
  static constexpr float kSensor_s = 0.02F;
  static constexpr float kTemperature_s = 0.1F;

  /// True from the sample on that a condition has lasted for: two samples at least, whatever lies between.
  class Lasting {
   public:
    bool step(bool now, float elapsed_s, float least_s) {
      for_s_ = now && before_ ? for_s_ + elapsed_s : 0.0F;
      before_ = now;
      return now && for_s_ >= least_s;
    }

   private:
    bool before_ = false;
    float for_s_ = 0.0F;
  };

  Lasting hot_;
  Lasting low_;
  Lasting high_;
  Lasting lost_;
  float temperature_C_ = 0.0F;
  float bus_V_ = 0.0F;
  bool warns_ = false;
  bool low_now_ = false;
};

}  // namespace slipstack
