// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/include/indicator.h"
#include "hal/lockstep/drivers.h"
#include "hal/lockstep/link_service.h"
#include "hal/mps2/memory_flash.h"
#include "hal/mps2/slcan.h"
#include "hal/mps2/uart.h"

extern "C" void tick_handler();
// Where the linker script puts what guest and host share: the begin of the PSRAM.
extern "C" std::byte __psram_begin[];  // NOLINT(bugprone-reserved-identifier)

namespace slipstack {

/// The emulated board in lock-step with a plant on the host: each turn of the link is a tick, between two
/// turns of the main loop (an exception would cost the emulator as much as the tick itself;
/// tests/budget/soak.cpp ticks by SysTick). CAN is SLCAN on UART1; flash lies behind the link in the shared
/// memory.
class BoardOfImage {
 public:
  BoardOfImage()
      : link_(*reinterpret_cast<PlantLink*>(__psram_begin)),
        encoder_(link_),
        motor_(link_),
        clock_(link_),
        watchdog_(link_),
        service_(link_),
        uart_(mps2::kUart1Address),
        can_(uart_),
        flash_(__psram_begin + PlantMemory::kFlashOffset) {}

  lockstep::LinkEncoder& encoder() { return encoder_; }
  lockstep::LinkMotor& motor_current() { return motor_; }
  lockstep::LinkClock& clock() { return clock_; }
  lockstep::LinkWatchdog& watchdog() { return watchdog_; }
  CanPort& can() { return can_; }
  Nonvolatile& nonvolatile() { return flash_; }
  Indicator& indicator() { return indicator_; }
  std::uint32_t tick_period() const { return 0; }

  bool start() {
    uart_.start();
    flash_.start();
    link_.magic = PlantLink::kMagic;
    return true;
  }

  bool wait(Controller& controller, const TickTiming& timing) {
    // Frames are served while the host thinks; a turn is not kept waiting by them.
    for (int i = 0; link_.host_sequence == sequence_; ++i) {
      if (i == kPolls) return true;
    }
    sequence_ = link_.host_sequence;
    if (link_.control_word == PlantLink::kQuit) return false;
    service_.take(controller);
    clock_.turn();
    tick_handler();
    service_.publish(controller, timing);
    asm volatile("dmb" ::: "memory");
    link_.guest_sequence = sequence_;
    return true;
  }
  void begin_tick() {}
  void end_tick() {}
  void on_can_interrupt() {}
  void on_lamp_interrupt() {}

 private:
  static constexpr int kPolls = 10000;

  class NoLamp final : public Indicator {
   public:
    void show(Indication) override {}
  };

  PlantLink& link_;
  lockstep::LinkEncoder encoder_;
  lockstep::LinkMotor motor_;
  lockstep::LinkClock clock_;
  lockstep::LinkWatchdog watchdog_;
  lockstep::LinkService service_;
  mps2::Uart uart_;
  mps2::SlcanPort<mps2::Uart> can_;
  mps2::MemoryFlash flash_;
  NoLamp indicator_;
  std::uint32_t sequence_ = 0;
};

}  // namespace slipstack
