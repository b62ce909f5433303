// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/supervision/digital_io.h"

namespace slipstack {

/// Levels of the output terminals, made in the main loop; the tick chooses those with the brake released or
/// those with the brake applied.
class OutputTerminals {
 public:
  /// Outside the tick, and again after a change of parameters: what 60FEh asks of the digital outputs.
  void set(const IoMasks& io, std::uint32_t wanted) {
    released_.store(output_levels(io, wanted, true), std::memory_order_relaxed);
    braked_.store(output_levels(io, wanted, false), std::memory_order_relaxed);
  }
  /// In the tick.
  std::uint32_t levels(bool brake_released) const {
    return (brake_released ? released_ : braked_).load(std::memory_order_relaxed);
  }

 private:
  std::atomic<std::uint32_t> released_{0};
  std::atomic<std::uint32_t> braked_{0};
};

}  // namespace slipstack
