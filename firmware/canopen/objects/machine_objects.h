// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "firmware/canopen/objects/object.h"
#include "firmware/control/parameters/parameters.h"
#include "hal/include/absolute_encoder.h"
#include "hal/include/signal_scaling.h"

// Objects of the manufacturer for what differs from one machine to the next: how its signals are scaled
// (2500h), the check of the direction at the first enabling (2501h), its thermal load (2502h), the interface
// of its encoder (2503h) and its analogue inputs (2504h).
namespace slipstack::canopen {

inline constexpr std::uint16_t kScalesIndex = 0x2500;
inline constexpr std::uint16_t kDirectionIndex = 0x2501;
inline constexpr std::uint16_t kThermalIndex = 0x2502;
inline constexpr std::uint16_t kEncoderIndex = 0x2503;
inline constexpr std::uint16_t kAnalogueIndex = 0x2504;

namespace detail {

constexpr Object axis_entry(std::uint16_t index, std::uint8_t sub, const char* name,
                            float AxisParameters::*member, const char* unit) {
  Object row = entry(index, sub, Type::kReal32, name).at_first(AxisParameters{}.*member).in(unit);
  for (const slipstack::detail::Bound& bound : slipstack::detail::kAxisBounds) {
    if (bound.member == member) row = row.within(bound.lower, bound.upper);
  }
  return row.stored(Storage::kParameter);
}

constexpr Object scale_entry(std::uint8_t sub, const char* name, float initial, float lower, float upper,
                             const char* unit) {
  return entry(kScalesIndex, sub, Type::kReal32, name)
      .within(lower, upper)
      .at_first(initial)
      .in(unit)
      .stored(Storage::kParameter);
}

}  // namespace detail

inline constexpr auto kMachineRows = [] {
  constexpr SignalScales kScales;
  return std::to_array<Object>({
      head(kScalesIndex, ObjectCode::kRecord, "Scales of the signals", 6),
      entry(kScalesIndex, 1, Type::kBoolean, "Encoder reversed").stored(Storage::kParameter),
      entry(kScalesIndex, 2, Type::kBoolean, "Motor reversed").stored(Storage::kParameter),
      detail::scale_entry(3, "Amplifier gain", kScales.command_A_per_V, 1.0e-3F, 1.0e3F, "A/V"),
      detail::scale_entry(4, "Command at zero current", kScales.command_zero_V, -1.0F, 1.0F, "V"),
      detail::scale_entry(5, "Current monitor gain", kScales.monitor_A_per_V, 1.0e-3F, 1.0e3F, "A/V"),
      detail::scale_entry(6, "Current monitor at zero current", kScales.monitor_zero_V, 0.0F, 3.3F, "V"),
      head(kDirectionIndex, ObjectCode::kRecord, "Direction check", 5),
      entry(kDirectionIndex, 1, Type::kBoolean, "Check at first enable")
          .at_first(1U)
          .stored(Storage::kParameter),
      detail::axis_entry(kDirectionIndex, 2, "Distance", &AxisParameters::check_distance_m, "m"),
      detail::axis_entry(kDirectionIndex, 3, "Largest current", &AxisParameters::check_current_A, "A"),
      detail::axis_entry(kDirectionIndex, 4, "Rate of the current", &AxisParameters::check_rate_A_per_s,
                         "A/s"),
      entry(kDirectionIndex, 5, Type::kU32, "Scales that passed").read_only().stored(Storage::kParameter),
      head(kThermalIndex, ObjectCode::kRecord, "Thermal load", 6),
      detail::axis_entry(kThermalIndex, 1, "Motor thermal time constant", &AxisParameters::motor_thermal_s,
                         "s"),
      detail::axis_entry(kThermalIndex, 2, "Amplifier rated current", &AxisParameters::amplifier_rated_A,
                         "A"),
      detail::axis_entry(kThermalIndex, 3, "Amplifier thermal time constant",
                         &AxisParameters::amplifier_thermal_s, "s"),
      entry(kThermalIndex, 4, Type::kBoolean, "Overload is a fault").stored(Storage::kParameter),
      reading(kThermalIndex, 5, Type::kReal32, "Load of the motor"),
      reading(kThermalIndex, 6, Type::kReal32, "Load of the amplifier"),
      head(kEncoderIndex, ObjectCode::kRecord, "Encoder interface", 9),
      entry(kEncoderIndex, 1, Type::kU8, "Kind (0 incremental, 1 BiSS-C)")
          .within(0, 1)
          .stored(Storage::kParameter),
      entry(kEncoderIndex, 2, Type::kU8, "Bits of the position")
          .within(8, 56)
          .at_first(std::uint32_t{EncoderInterface{}.position_bits})
          .stored(Storage::kParameter),
      entry(kEncoderIndex, 3, Type::kU8, "Lowest bits that are dropped")
          .within(0, 48)
          .stored(Storage::kParameter),
      reading(kEncoderIndex, 4, Type::kU32, "Frames without an answer"),
      reading(kEncoderIndex, 5, Type::kU32, "Frames with a wrong check sum"),
      reading(kEncoderIndex, 6, Type::kU32, "Frames with the error bit"),
      reading(kEncoderIndex, 7, Type::kU32, "Frames with the warning bit"),
      reading(kEncoderIndex, 8, Type::kBoolean, "Warning of the last frame"),
      detail::axis_entry(kEncoderIndex, 9, "Motion that may go unseen (0: off)",
                         &AxisParameters::unseen_motion_m, "m"),
      head(kAnalogueIndex, ObjectCode::kRecord, "Temperature and DC link voltage", 8),
      detail::axis_entry(kAnalogueIndex, 1, "Temperature input gain (0: none)",
                         &AxisParameters::temperature_C_per_V, "degC/V"),
      detail::axis_entry(kAnalogueIndex, 2, "Temperature at 0 V", &AxisParameters::temperature_at_zero_C,
                         "degC"),
      detail::axis_entry(kAnalogueIndex, 3, "Temperature of the warning",
                         &AxisParameters::temperature_warning_C, "degC"),
      detail::axis_entry(kAnalogueIndex, 4, "Temperature of the fault", &AxisParameters::temperature_fault_C,
                         "degC"),
      reading(kAnalogueIndex, 5, Type::kReal32, "Motor temperature").in("degC"),
      detail::axis_entry(kAnalogueIndex, 6, "DC link input gain (0: none)", &AxisParameters::bus_V_per_V,
                         "V/V"),
      detail::axis_entry(kAnalogueIndex, 7, "DC link least voltage", &AxisParameters::bus_lowest_V, "V"),
      detail::axis_entry(kAnalogueIndex, 8, "DC link largest voltage", &AxisParameters::bus_highest_V, "V"),
  });
}();

}  // namespace slipstack::canopen
