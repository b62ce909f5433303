// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/indicator.h"

namespace slipstack::stm32g474 {

// One step of a pattern lasts 50 ms.
inline constexpr std::uint32_t kPatternStep_ms = 50;

// Whether the LED is lit at a step, after CiA 303-3 table 3 (one green LED: the fault is its double flash).
constexpr bool led_lit(Indication indication, std::uint32_t step) {
  switch (indication) {
    case Indication::kStarting:
      return step % 2 == 0;  // flickering, 10 Hz
    case Indication::kDisabled:
      return step % 24 < 4;  // single flash: 200 ms on, 1000 ms off
    case Indication::kReady:
      return step % 8 < 4;  // blinking, 2.5 Hz
    case Indication::kEnabled:
      return true;  // on
    case Indication::kFault:
      return step % 32 < 4 || (step % 32 >= 8 && step % 32 < 12);  // double flash
  }
  return false;
}

// What the main loop shows, a timer's interrupt draws by step().
template <class LedType>
class LedIndicator final : public Indicator {
 public:
  explicit LedIndicator(LedType& led) : led_(led) {}

  void show(Indication indication) override { indication_ = static_cast<std::uint8_t>(indication); }
  // Every kPatternStep_ms.
  void step() { led_.set(led_lit(static_cast<Indication>(static_cast<std::uint8_t>(indication_)), step_++)); }

 private:
  LedType& led_;
  volatile std::uint8_t indication_ = static_cast<std::uint8_t>(Indication::kStarting);
  std::uint32_t step_ = 0;
};

}  // namespace slipstack::stm32g474
