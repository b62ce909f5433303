// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

/// The command time-out (2403h) of the cyclic modes: from the first set-point on, the master's commands must
/// not fail to come for longer. The tick itself watches the time, and takes back the bits of the controlword
/// that the abort connection option (6007h) names.
class CommandSupervision {
 public:
  explicit CommandSupervision(Controller& controller) : controller_(controller) {}

  /// A command came; `set_point`: one of a cyclic mode, while operation is enabled.
  void received(const Dictionary& dictionary, bool set_point) {
    active_ |= set_point;
    const float ticks = static_cast<float>(dictionary.value(kRow<kCommandTimeoutIndex>)) * 1e-3F /
                        controller_.parameters().axis.tick_s;
    controller_.commanded(static_cast<std::uint32_t>(ticks));
  }

  /// Set-points are awaited only from the next one on.
  void rest() { active_ = false; }

  /// Options of Controller::command_all(). `moving`: the axis acts on a set-point from before.
  std::uint32_t options(const Dictionary& dictionary, bool moving) const {
    const bool on = dictionary.value(kRow<kCommandTimeoutIndex>) != 0;
    return on && (active_ || moving) ? std::uint32_t{reaction(dictionary)} << kReactionShift : 0U;
  }

  /// Bits of the controlword that a lost master takes back. A quick stop without braking (605Ah: 0) is
  /// current off. Where the loss is to be a fault the tick begins to brake, and the main loop raises it.
  static std::uint16_t reaction(const Dictionary& dictionary) {
    switch (dictionary.value(kRow<0x6007>)) {
      case 1:
        return kQuickStop;
      case 2:
        return kEnableVoltage;
      case 3:
        return dictionary.value(kRow<0x605A>) == 0 ? kEnableVoltage : kQuickStop;
      default:
        return 0;
    }
  }

  /// 6007h = 1: the loss is a fault.
  static bool is_fault(const Dictionary& dictionary) { return dictionary.value(kRow<0x6007>) == 1; }

  bool lost() const { return controller_.command_lost(); }

 private:
  Controller& controller_;
  bool active_ = false;
};

}  // namespace slipstack::canopen
