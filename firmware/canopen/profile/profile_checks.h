// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/profile/homing_profile.h"
#include "firmware/canopen/profile/profile_context.h"
#include "firmware/canopen/profile/touch_probe_profile.h"

namespace slipstack::canopen {

/// Whether an object of the drive profile may have this value, beyond the bounds in the object table.
inline Abort check_profile_object(const ProfileContext& context, std::size_t row, std::uint32_t value) {
  switch (kObjects[row].index) {
    case 0x605A:  // not by a limit of current or voltage (docs/can.md)
      return value == 3 || value == 4 ? Abort::kBadValue : Abort::kNone;
    case 0x6060: {
      const auto mode = static_cast<Mode>(static_cast<std::int8_t>(value));
      const bool known = mode == Mode::kNone || mode == Mode::kProfilePosition ||
                         mode == Mode::kProfileVelocity || mode == Mode::kHoming ||
                         mode == Mode::kCyclicPosition || mode == Mode::kCyclicVelocity ||
                         mode == Mode::kCyclicTorque;
      return known ? Abort::kNone : Abort::kBadValue;
    }
    case 0x607A:
    case 0x607C:
    case 0x60B0: {
      const auto wanted = static_cast<std::int32_t>(value);
      if (context.units.to_counts(wanted)) return Abort::kNone;
      return wanted < 0 ? Abort::kTooLow : Abort::kTooHigh;
    }
    case 0x607E:
      if ((value & ~(UserUnits::kPosition | UserUnits::kVelocity)) != 0) return Abort::kBadValue;
      return Abort::kNone;
    case 0x608F:
    case 0x6091:
    case 0x6092:
      return UserUnits::of(*context.dictionary, row, value) ? Abort::kNone : Abort::kBadValue;
    case 0x60B8:
      return TouchProbeProfile::check(*context.dictionary, value);
    case 0x6098:
      return HomingProfile::supported(value) ? Abort::kNone : Abort::kBadValue;
    default:
      return Abort::kNone;
  }
}

}  // namespace slipstack::canopen
