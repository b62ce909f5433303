// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "firmware/canopen/objects/object.h"
#include "firmware/control/homing/homing_methods.h"

// Objects of the drive profile (CiA 402, IEC 61800-7-201): 6000h and up. Position is in the user's unit,
// which 608Fh, 6091h and 6092h make of encoder counts (user_units.h) and is a count as delivered; force in
// thousandths of the rated force (6076h).
namespace slipstack::canopen {

inline constexpr std::uint32_t kSupportedModes =
    (1U << 0) | (1U << 2) | (1U << 5) | (1U << 7) | (1U << 8) | (1U << 9);  ///< pp, pv, hm, csp, csv, cst

/// A number of the factor group.
constexpr Object factor(std::uint16_t index, std::uint8_t sub, const char* name) {
  return entry(index, sub, Type::kU32, name).within(1U, 0xFFFFFFFFU).at_first(1U).stored(Storage::kParameter);
}

inline constexpr auto kProfileObjects = [] {
  constexpr Storage kParameter = Storage::kParameter;
  // Belongs to a set-point, and may change from one to the next.
  constexpr Storage kSetting = Storage::kSetting;
  constexpr Mapping kOut = Mapping::kTransmit;
  constexpr Mapping kIn = Mapping::kBoth;
  return std::to_array<Object>({
      variable(0x6007, Type::kI16, "Abort connection option code")
          .within(0, 3)
          .at_first(3U)
          .stored(kParameter),
      variable(0x603F, Type::kU16, "Error code").read_only().from_device().mapped(kOut),
      variable(0x6040, Type::kU16, "Controlword").mapped(kIn).from_device(),
      variable(0x6041, Type::kU16, "Statusword").read_only().from_device().mapped(kOut),
      variable(0x605A, Type::kI16, "Quick stop option code").within(0, 6).at_first(2U).stored(kParameter),
      variable(0x605B, Type::kI16, "Shutdown option code").within(0, 1).stored(kParameter),
      variable(0x605C, Type::kI16, "Disable operation option code")
          .within(0, 1)
          .at_first(1U)
          .stored(kParameter),
      variable(0x605D, Type::kI16, "Halt option code").within(1, 2).at_first(1U).stored(kParameter),
      variable(0x605E, Type::kI16, "Fault reaction option code").within(0, 2).at_first(2U).stored(kParameter),
      variable(0x6060, Type::kI8, "Modes of operation").mapped(kIn).from_device(),
      variable(0x6061, Type::kI8, "Modes of operation display").read_only().from_device().mapped(kOut),
      variable(0x6063, Type::kI32, "Position actual internal value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("count"),
      variable(0x6064, Type::kI32, "Position actual value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      variable(0x6067, Type::kU32, "Position window").at_first(1000U).in("user unit").stored(kSetting),
      variable(0x6068, Type::kU16, "Position window time").at_first(10U).in("s", 1e-3F).stored(kSetting),
      variable(0x606B, Type::kI32, "Velocity demand value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit/s"),
      variable(0x606C, Type::kI32, "Velocity actual value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit/s"),
      variable(0x606D, Type::kU16, "Velocity window").at_first(10000U).in("user unit/s").stored(kSetting),
      variable(0x606E, Type::kU16, "Velocity window time").at_first(10U).in("s", 1e-3F).stored(kSetting),
      variable(0x606F, Type::kU16, "Velocity threshold").at_first(5000U).in("user unit/s").stored(kSetting),
      variable(0x6070, Type::kU16, "Velocity threshold time").at_first(10U).in("s", 1e-3F).stored(kSetting),
      variable(0x6071, Type::kI16, "Target torque").mapped(kIn).from_device().in("rated force", 1e-3F),
      variable(0x6074, Type::kI16, "Torque demand")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("rated force", 1e-3F),
      variable(0x6075, Type::kU32, "Motor rated current")
          .within(1, 1000000)
          .at_first(10000U)
          .in("A", 1e-3F)
          .stored(kParameter),
      variable(0x6076, Type::kU32, "Motor rated torque").read_only().from_device().in("N", 1e-3F),
      variable(0x6077, Type::kI16, "Torque actual value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("rated force", 1e-3F),
      variable(0x6079, Type::kU32, "DC link circuit voltage")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("V", 1e-3F),
      variable(0x607A, Type::kI32, "Target position").mapped(kIn).from_device().in("user unit"),
      variable(0x607C, Type::kI32, "Home offset").in("user unit").stored(kSetting),
      head(0x607D, ObjectCode::kArray, "Software position limit", 2),
      entry(0x607D, 1, Type::kI32, "Min position limit")
          .at_first(std::numeric_limits<std::int32_t>::min())
          .in("user unit")
          .stored(kSetting),
      entry(0x607D, 2, Type::kI32, "Max position limit")
          .at_first(std::numeric_limits<std::int32_t>::max())
          .in("user unit")
          .stored(kSetting),
      // Bit 7: position, bit 6: velocity.
      variable(0x607E, Type::kU8, "Polarity").within(0, 0xC0).stored(kParameter),
      variable(0x607F, Type::kU32, "Max profile velocity")
          .within(1U, 0xFFFFFFFFU)
          .at_first(0xFFFFFFFFU)
          .in("user unit/s")
          .stored(kSetting),
      variable(0x6080, Type::kU32, "Max motor speed")
          .within(1U, 0xFFFFFFFFU)
          .at_first(0xFFFFFFFFU)
          .in("m/s", 1e-3F)
          .stored(kSetting),
      variable(0x6081, Type::kU32, "Profile velocity")
          .within(1, 2000000000)
          .at_first(100000U)
          .mapped(kIn)
          .in("user unit/s")
          .stored(kSetting),
      variable(0x6083, Type::kU32, "Profile acceleration")
          .within(1, 2000000000)
          .at_first(1000000U)
          .mapped(kIn)
          .in("user unit/s2")
          .stored(kSetting),
      variable(0x6084, Type::kU32, "Profile deceleration")
          .within(1, 2000000000)
          .at_first(1000000U)
          .mapped(kIn)
          .in("user unit/s2")
          .stored(kSetting),
      variable(0x6085, Type::kU32, "Quick stop deceleration")
          .within(1U, 0xFFFFFFFFU)
          .at_first(0xFFFFFFFFU)
          .in("user unit/s2")
          .stored(kSetting),
      head(0x608F, ObjectCode::kArray, "Position encoder resolution", 2),
      factor(0x608F, 1, "Encoder increments").in("count"),
      factor(0x608F, 2, "Motor revolutions"),
      head(0x6091, ObjectCode::kArray, "Gear ratio", 2),
      factor(0x6091, 1, "Motor revolutions"),
      factor(0x6091, 2, "Shaft revolutions"),
      head(0x6092, ObjectCode::kArray, "Feed constant", 2),
      factor(0x6092, 1, "Feed").in("user unit"),
      factor(0x6092, 2, "Shaft revolutions"),
      variable(0x6098, Type::kI8, "Homing method").stored(kSetting),
      head(0x6099, ObjectCode::kArray, "Homing speeds", 2),
      entry(0x6099, 1, Type::kU32, "Speed during search for switch")
          .within(1, 2000000000)
          .at_first(50000U)
          .in("user unit/s")
          .stored(kSetting),
      entry(0x6099, 2, Type::kU32, "Speed during search for zero")
          .within(1, 2000000000)
          .at_first(5000U)
          .in("user unit/s")
          .stored(kSetting),
      variable(0x609A, Type::kU32, "Homing acceleration")
          .within(1, 2000000000)
          .at_first(1000000U)
          .in("user unit/s2")
          .stored(kSetting),
      head(0x60A4, ObjectCode::kArray, "Profile jerk", 1),
      entry(0x60A4, 1, Type::kU32, "Profile jerk")
          .within(1, 2147483647)
          .at_first(100000000U)
          .in("user unit/s3")
          .stored(kSetting),
      variable(0x60B0, Type::kI32, "Position offset").mapped(kIn).from_device().in("user unit"),
      variable(0x60B1, Type::kI32, "Velocity offset").mapped(kIn).from_device().in("user unit/s"),
      variable(0x60B2, Type::kI16, "Torque offset").mapped(kIn).from_device().in("rated force", 1e-3F),
      variable(0x60B8, Type::kU16, "Touch probe function").mapped(kIn),
      variable(0x60B9, Type::kU16, "Touch probe status").read_only().from_device().mapped(kOut),
      variable(0x60BA, Type::kI32, "Touch probe 1 positive edge")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      variable(0x60BB, Type::kI32, "Touch probe 1 negative edge")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      variable(0x60BC, Type::kI32, "Touch probe 2 positive edge")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      variable(0x60BD, Type::kI32, "Touch probe 2 negative edge")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      head(0x60C2, ObjectCode::kRecord, "Interpolation time period", 2),
      entry(0x60C2, 1, Type::kU8, "Interpolation time period value")
          .within(1, 255)
          .at_first(1U)
          .stored(kParameter),
      entry(0x60C2, 2, Type::kI8, "Interpolation time index")
          .within(-4, -1)
          .at_first(0xFFFFFFFDU)
          .stored(kParameter),
      variable(0x60C5, Type::kU32, "Max acceleration")
          .within(1U, 0xFFFFFFFFU)
          .at_first(0xFFFFFFFFU)
          .in("user unit/s2")
          .stored(kSetting),
      variable(0x60C6, Type::kU32, "Max deceleration")
          .within(1U, 0xFFFFFFFFU)
          .at_first(0xFFFFFFFFU)
          .in("user unit/s2")
          .stored(kSetting),
      variable(0x60D5, Type::kU16, "Touch probe 1 positive edge counter")
          .read_only()
          .from_device()
          .mapped(kOut),
      variable(0x60D6, Type::kU16, "Touch probe 1 negative edge counter")
          .read_only()
          .from_device()
          .mapped(kOut),
      variable(0x60D7, Type::kU16, "Touch probe 2 positive edge counter")
          .read_only()
          .from_device()
          .mapped(kOut),
      variable(0x60D8, Type::kU16, "Touch probe 2 negative edge counter")
          .read_only()
          .from_device()
          .mapped(kOut),
  });
}();

/// 60E3h: every method there is.
inline constexpr auto kHomingMethodRows = [] {
  std::array<Object, kHomingMethods.size() + 1> rows{};
  rows[0] = head(0x60E3, ObjectCode::kArray, "Supported homing methods", kHomingMethods.size());
  for (std::size_t i = 1; i < rows.size(); ++i) {
    rows[i] = entry(0x60E3, static_cast<std::uint8_t>(i), Type::kI8, "Supported homing method")
                  .constant(static_cast<std::uint32_t>(kHomingMethods[i - 1].number));
    rows[i].number = static_cast<int>(i);
  }
  return rows;
}();

inline constexpr auto kLastProfileObjects = [] {
  constexpr Mapping kOut = Mapping::kTransmit;
  constexpr Mapping kIn = Mapping::kBoth;
  return std::to_array<Object>({
      variable(0x60F4, Type::kI32, "Following error actual value")
          .read_only()
          .from_device()
          .mapped(kOut)
          .in("user unit"),
      variable(0x60FD, Type::kU32, "Digital inputs").read_only().from_device().mapped(kOut),
      head(0x60FE, ObjectCode::kArray, "Digital outputs", 2),
      entry(0x60FE, 1, Type::kU32, "Physical outputs").mapped(kIn),
      entry(0x60FE, 2, Type::kU32, "Bit mask").mapped(kIn).stored(Storage::kSetting),
      variable(0x60FF, Type::kI32, "Target velocity").mapped(kIn).from_device().in("user unit/s"),
      variable(0x6502, Type::kU32, "Supported drive modes").constant(kSupportedModes),
  });
}();

}  // namespace slipstack::canopen
