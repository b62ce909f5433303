// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/current/thermal_limit.h"
#include "firmware/control/parameters/control_set.h"

namespace slipstack {

/// I2t by samples of the current in the main loop, and what it leaves of the current limit for the tick.
class LoadWatch {
 public:
  /// In the tick: the limit of new parameters, until the next sample.
  void begin(float limit_A) { largest_A_.store(limit_A, std::memory_order_relaxed); }
  /// In the tick: the largest current that may be commanded now.
  float largest_A() const { return largest_A_.load(std::memory_order_relaxed); }

  /// In every pass of the main loop: the heat of one sample of the current since the last one. True when the
  /// load has just been spent, and that is a fault of this axis.
  bool step(const ControlSet& set, std::uint32_t tick, bool driving, float measured_A) {
    const auto elapsed_s = static_cast<float>(tick - last_tick_) * set.axis.tick_s;
    last_tick_ = tick;
    if (!set.valid) return false;
    thermal_.step(set.axis, elapsed_s, driving ? measured_A : 0.0F);
    largest_A_.store(thermal_.limit_A(), std::memory_order_relaxed);
    const bool first = !was_spent_ && thermal_.spent();
    was_spent_ = thermal_.spent();
    return first && set.axis.overload_is_fault && driving;
  }
  /// As of the last sample.
  const ThermalLimit& thermal() const { return thermal_; }

 private:
  std::atomic<float> largest_A_{0.0F};
  ThermalLimit thermal_;
  std::uint32_t last_tick_ = 0;
  bool was_spent_ = false;
};

}  // namespace slipstack
