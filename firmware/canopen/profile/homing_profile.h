// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/profile/user_units.h"
#include "firmware/control/homing/homing.h"

namespace slipstack::canopen {

/// Homing mode (IEC 61800-7-201, hm): its objects, and its bits of controlword and statusword.
class HomingProfile {
 public:
  /// `units`: as they are when homing starts.
  HomingProfile(Controller& controller, const UserUnits& units)
      : controller_(controller), units_(units), homing_(controller) {}

  /// Whether 6098h may have this value; 0 is none.
  static bool supported(std::uint32_t method) {
    const auto number = static_cast<std::int8_t>(method);
    return number == 0 || find_homing_method(number) != nullptr;
  }

  /// A controlword while homing is the mode. Bit 4 starts, its fall or halt (bit 8) interrupts; when halt is
  /// released homing begins anew. Methods without a motion need no axis that is enabled.
  void controlword(const Dictionary& dictionary, std::uint16_t word, std::uint16_t changed, bool enabled) {
    if ((word & (kStartBit | kHaltBit)) != kStartBit) return homing_.interrupt();
    if ((changed & (kStartBit | kHaltBit)) == 0) return;
    const HomingSettings settings = settings_of(dictionary);
    const bool moves =
        settings.method == nullptr || settings.method->search != 0 || settings.method->index != 0;
    if (enabled || !moves) homing_.start(settings);
  }
  /// Another mode.
  void reset() { homing_.reset(); }

  /// In every pass of the main loop while homing is the mode.
  void step(Dictionary& dictionary, bool enabled) {
    if (!enabled && homing_.moves_the_axis()) homing_.reset();
    homing_.step();
    // To be stored by 1010h: an absolute encoder is homed once.
    const bool found = homing_.state() == Homing::State::kAttained || homing_.state() == Homing::State::kDone;
    if (found && controller_.parameters().axis.reference.absolute_encoder) {
      dictionary.set(kRow<kReferenceIndex, 2>, static_cast<std::uint32_t>(controller_.position().origin()));
    }
  }

  /// Bits 10, 12 and 13 of the statusword.
  std::uint16_t status() const {
    const unsigned standing = controller_.reference().standing() ? kTargetReachedBit : 0U;
    switch (homing_.state()) {
      case Homing::State::kNotStarted:
        return static_cast<std::uint16_t>(standing);
      case Homing::State::kRunning:
        return 0;
      case Homing::State::kAttained:
        return kAttainedBit;
      case Homing::State::kDone:
        return kAttainedBit | kTargetReachedBit;
      default:
        return static_cast<std::uint16_t>(kErrorBit | standing);
    }
  }

 private:
  static constexpr std::uint16_t kStartBit = 1U << 4;
  static constexpr std::uint16_t kHaltBit = 1U << 8;
  static constexpr unsigned kTargetReachedBit = 1U << 10;
  static constexpr unsigned kAttainedBit = 1U << 12;
  static constexpr unsigned kErrorBit = 1U << 13;

  HomingSettings settings_of(const Dictionary& dictionary) const {
    const float tick_s = controller_.parameters().axis.tick_s;
    HomingSettings settings;
    settings.method = find_homing_method(static_cast<std::int8_t>(dictionary.value(kRow<0x6098>)));
    settings.fast = limits(dictionary, dictionary.value(kRow<0x6099, 1>), tick_s);
    settings.slow = limits(dictionary, dictionary.value(kRow<0x6099, 2>), tick_s);
    settings.home_offset =
        units_.to_counts(static_cast<std::int32_t>(dictionary.value(kRow<0x607C>))).value_or(0);
    settings.timeout_ticks = static_cast<std::uint32_t>(dictionary.real(kRow<kHomingIndex, 1>) / tick_s);
    settings.end_stop_A = dictionary.real(kRow<kHomingIndex, 2>);
    settings.end_stop_ticks = static_cast<std::uint32_t>(dictionary.real(kRow<kHomingIndex, 3>) / tick_s);
    return settings;
  }
  MotionLimits limits(const Dictionary& dictionary, std::uint32_t speed, float tick_s) const {
    const float per_user = units_.counts_per_user() * tick_s;
    const float acceleration = static_cast<float>(dictionary.value(kRow<0x609A>)) * per_user * tick_s;
    const float jerk = static_cast<float>(dictionary.value(kRow<0x60A4, 1>)) * per_user * tick_s * tick_s;
    return {static_cast<float>(speed) * per_user, acceleration, acceleration, jerk};
  }

  Controller& controller_;
  const UserUnits& units_;
  Homing homing_;
};

}  // namespace slipstack::canopen
