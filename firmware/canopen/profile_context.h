// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/dictionary.h"
#include "firmware/canopen/profile_units.h"
#include "firmware/canopen/user_units.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

/// Modes of operation, 6060h.
enum class Mode : std::int8_t {
  kNone = 0,
  kProfilePosition = 1,
  kHoming = 6,
  kCyclicPosition = 8,
  kCyclicTorque = 10
};

/// What the parts of the drive profile share: the axis, its objects in the user's units, controlword and
/// mode.
struct ProfileContext {
  explicit ProfileContext(Controller& axis) : controller(axis) {}

  static constexpr std::uint16_t kHaltBit = 1U << 8;

  std::uint32_t value(std::size_t row) const { return dictionary->value(row); }
  const AxisParameters& axis() const { return controller.parameters().axis; }

  /// And not on the way out of it.
  bool operation_enabled() const { return controller.state().follows_commands(); }
  bool halted() const { return (control & kHaltBit) != 0; }

  /// Counts from position zero.
  std::int32_t place(std::int32_t counts) const { return controller.position().position_of(counts); }
  /// 6064h, 607Ah: the user's unit outside, counts inside. What does not fit was refused when it was written.
  std::uint32_t position() const {
    return static_cast<std::uint32_t>(units.to_user(place(controller.measured_counts())));
  }
  /// 607Ah in counts: from position zero, or a distance.
  std::int32_t target() const {
    return units.to_counts(static_cast<std::int32_t>(value(kRow<0x607A>)))
        .value_or(place(controller.measured_counts()));
  }

  Controller& controller;
  Dictionary* dictionary = nullptr;
  UserUnits units;
  std::uint16_t control = 0;  ///< 6040h
  Mode mode = Mode::kNone;    ///< in force, 6061h
};

}  // namespace slipstack::canopen
