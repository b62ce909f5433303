// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/stm32g474/board.h"
#include "hal/stm32g474/peripherals.h"

namespace slipstack {

/// The NUCLEO-G474RE for firmware/app/main.cpp: current set-point by DAC, ticks from TIM6.
class BoardOfImage : public stm32g474::Board<stm32g474::DriveKind::kDac, stm32g474::Part> {
 public:
  BoardOfImage() : Board(kSetup) {}

  std::uint32_t tick_period() const { return stm32g474::kCore_Hz / kSetup.tick_rate_Hz; }
  // The node joins the bus, at the bit rate that is stored.
  bool start() { return Board::start({}, false) == stm32g474::BoardFault::kNone; }
  bool wait() {
    // Until the next interrupt: the tick's at the latest.
    asm volatile("wfi");
    return true;
  }
  void begin_tick() { tick_timer().begin(); }
  void end_tick() { tick_timer().end(); }
  void on_can_interrupt() { can().on_interrupt(); }
  void on_encoder_interrupt() { biss().on_interrupt(); }
  void on_indicator_interrupt() { indicator().step(); }

 private:
  static constexpr stm32g474::BoardSetup kSetup{};
};

}  // namespace slipstack
