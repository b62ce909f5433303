// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/controller.h"
#include "firmware/control/homing/homing_methods.h"

namespace slipstack {

/// The switches as a homing method sees them.
class HomingSwitches {
 public:
  explicit HomingSwitches(const Controller& controller) : controller_(controller) {}

  /// The method that counts from now on.
  void use(const HomingMethod& method) { sensor_ = method.sensor; }

  /// The method's switch is connected, or it has none; the marks are coded where it needs that.
  bool wired() const {
    if (sensor_ == HomingMethod::Sensor::kCodedMarks)
      return controller_.parameters().axis.reference.coded_distance != 0;
    return sensor_ == HomingMethod::Sensor::kNone || sensor_ == HomingMethod::Sensor::kEndStop || mask() != 0;
  }
  /// The method's switch is active.
  bool on_switch() const { return (controller_.inputs().active(io()) & mask()) != 0; }
  /// The limit switch in this direction is active.
  bool limit(std::int32_t direction) const {
    const DigitalInputs& inputs = controller_.inputs();
    return direction > 0 ? inputs.positive_limit(io()) : inputs.negative_limit(io());
  }
  /// The method searches a limit switch.
  bool searches_limit() const {
    return sensor_ == HomingMethod::Sensor::kNegativeLimit || sensor_ == HomingMethod::Sensor::kPositiveLimit;
  }
  /// Terminals of the method's switch, bits of IoMasks.
  std::uint32_t mask() const {
    switch (sensor_) {
      case HomingMethod::Sensor::kNegativeLimit:
        return io().negative_limit;
      case HomingMethod::Sensor::kPositiveLimit:
        return io().positive_limit;
      case HomingMethod::Sensor::kHomeSwitch:
        return io().home_switch;
      default:
        return 0;
    }
  }

 private:
  const IoMasks& io() const { return controller_.parameters().io; }

  const Controller& controller_;
  HomingMethod::Sensor sensor_ = HomingMethod::Sensor::kNone;
};

}  // namespace slipstack
