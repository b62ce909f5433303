// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/profile/profile_units.h"
#include "firmware/canopen/profile/user_units.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

/// Modes of operation, 6060h.
enum class Mode : std::int8_t {
  kNone = 0,
  kProfilePosition = 1,
  kProfileVelocity = 3,
  kHoming = 6,
  kCyclicPosition = 8,
  kCyclicVelocity = 9,
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

  /// 607Ah and 60B0h together; 607Ah alone where they do not fit.
  std::int32_t target_with_offset() const {
    const std::int64_t both = std::int64_t{static_cast<std::int32_t>(value(kRow<0x607A>))} +
                              static_cast<std::int32_t>(value(kRow<0x60B0>));
    if (both != static_cast<std::int32_t>(both)) return target();
    return units.to_counts(static_cast<std::int32_t>(both)).value_or(target());
  }
  /// 60FFh, and with it other velocities, in counts per tick.
  float velocity_in_ticks(float user_per_s) const {
    return units.velocity_in_counts(user_per_s) * axis().tick_s;
  }
  /// Of the reference.
  float demand_counts_per_s() const { return from_fixed(controller.ahead(0).velocity) / axis().tick_s; }
  /// In counts and ticks: a velocity, 6083h, 6084h and 60A4h or what of them a set-point has.
  MotionLimits limits(std::uint32_t velocity, std::uint32_t acceleration, std::uint32_t deceleration,
                      std::uint32_t jerk) const {
    const float tick_s = axis().tick_s;
    const auto in_ticks = [this](std::uint32_t per_second, float scale) {
      return static_cast<float>(per_second) * (units.counts_per_user() * scale);
    };
    return {in_ticks(velocity, tick_s), in_ticks(acceleration, tick_s * tick_s),
            in_ticks(deceleration, tick_s * tick_s), in_ticks(jerk, tick_s * tick_s * tick_s)};
  }

  Controller& controller;
  Dictionary* dictionary = nullptr;
  UserUnits units;
  std::uint16_t control = 0;  ///< 6040h
  Mode mode = Mode::kNone;    ///< in force, 6061h
};

}  // namespace slipstack::canopen
