// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// The states that the LED of the board shows. Patterns are those of the CiA 303-3 run and error LEDs,
/// drawn by the board.
enum class Indication : std::uint8_t { kStarting, kDisabled, kReady, kEnabled, kFault };

/// One LED, or more; used outside the tick.
class Indicator {
 public:
  virtual void show(Indication indication) = 0;

 protected:
  ~Indicator() = default;
};

}  // namespace slipstack
