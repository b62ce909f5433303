// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/include/indicator.h"
#include "hal/mps2/memory_flash.h"
#include "hal/mps2/slcan.h"
#include "hal/mps2/uart.h"
#include "hal/plant_link/drivers.h"

// Where the linker script puts what guest and host share: the begin of the PSRAM.
extern "C" std::byte __psram_begin[];  // NOLINT(bugprone-reserved-identifier)

namespace slipstack {

/// The emulated board, whose encoder and motor are those of a plant that the host simulates: a tick for each
/// turn that the host requests through the PlantLink, between two turns of the main loop. An exception would
/// cost the emulator as much time as the tick itself; tests/budget/soak.cpp ticks by SysTick. CAN is SLCAN on
/// UART1; the flash pages lie behind the link in the shared memory.
class BoardOfImage : public LinkDevices {
 public:
  BoardOfImage()
      : LinkDevices(*reinterpret_cast<PlantLink*>(__psram_begin)),
        uart_(mps2::kUart1Address),
        can_(uart_),
        flash_(__psram_begin + PlantMemory::kFlashOffset) {}

  CanPort& can() { return can_; }
  Nonvolatile& nonvolatile() { return flash_; }
  Indicator& indicator() { return indicator_; }
  /// The emulator has no number of its own.
  static std::uint32_t serial_number() { return 1; }

  bool start() {
    uart_.start();
    flash_.start();
    link().magic = PlantLink::kMagic;
    return true;
  }

  /// Until the host requests a turn, but not longer than the main loop may leave frames unserved. False: the
  /// host ends the program.
  bool wait() {
    const std::uint32_t served = link().guest_sequence;
    for (int i = 0; i < kPolls; ++i) {
      if (link().host_sequence != served) return link().control_word != PlantLink::kQuit;
    }
    return true;
  }
  void begin_tick() {}
  void end_tick() {}
  void on_can_interrupt() {}
  void on_encoder_interrupt() {}
  void on_indicator_interrupt() {}

 private:
  static constexpr int kPolls = 10000;

  class NoIndicator final : public Indicator {
   public:
    void show(Indication) override {}
  };

  mps2::Uart uart_;
  mps2::SlcanPort<mps2::Uart> can_;
  mps2::MemoryFlash flash_;
  NoIndicator indicator_;
};

}  // namespace slipstack
