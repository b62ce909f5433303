// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/telemetry/telemetry.h"
#include "firmware/control/controller.h"
#include "hal/include/analogue_inputs.h"

namespace slipstack::canopen {

/// 2504h and 6079h: what the board's analogue inputs stand for and say. Of a signal that the board does not
/// have, the gain stays 0 (06010000h); of one that is not wired there is nothing to be read (08000024h).
class AnalogueObjects {
 public:
  /// `inputs`: of the board; nullptr where it has none.
  AnalogueObjects(Controller& controller, AnalogueInputs* inputs)
      : controller_(controller), inputs_(inputs) {}

  /// In every pass of the main loop.
  void step() {
    if (inputs_ != nullptr) controller_.sense({inputs_->temperature(), inputs_->bus_voltage()});
  }

  std::uint32_t temperature() const {
    return std::bit_cast<std::uint32_t>(has_temperature() ? controller_.analogue().temperature_C() : 0.0F);
  }
  /// mV.
  std::uint32_t bus_voltage() const {
    return has_bus() ? rounded(controller_.analogue().bus_V() * 1e3F, 2.1e9F) : 0U;
  }

  Abort check_read(const Object& object) const {
    const bool none = (object.index == 0x6079 && !has_bus()) ||
                      (object.index == kAnalogueIndex && object.sub == 5 && !has_temperature());
    return none ? Abort::kNoData : Abort::kNone;
  }
  Abort check(std::uint8_t sub, std::uint32_t value) const {
    const bool wires = std::bit_cast<float>(value) != 0.0F;
    const bool missing = (sub == 1 && (inputs_ == nullptr || !inputs_->has_temperature())) ||
                         (sub == 6 && (inputs_ == nullptr || !inputs_->has_bus_voltage()));
    return wires && missing ? Abort::kUnsupportedAccess : Abort::kNone;
  }

 private:
  bool has_temperature() const { return controller_.parameters().axis.temperature_C_per_V != 0.0F; }
  bool has_bus() const { return controller_.parameters().axis.bus_V_per_V != 0.0F; }

  Controller& controller_;
  AnalogueInputs* inputs_;
};

}  // namespace slipstack::canopen
