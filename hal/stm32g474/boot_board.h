// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/cortex_m/enter_program.h"
#include "hal/stm32g474/board.h"
#include "hal/stm32g474/gpio.h"
#include "hal/stm32g474/peripherals.h"
#include "hal/stm32g474/program_flash.h"
#include "hal/stm32g474/timing.h"

namespace slipstack {

/// The NUCLEO-G474RE for firmware/app/boot_main.cpp: flash and watchdog, on the clock that a reset leaves
/// (HSI16), no interrupts. The outputs are safe before it begins (startup.cpp).
class BootBoard {
 public:
  /// A program must take the watchdog over within this time, or the part is reset: the firmware sets 20 ms
  /// once its clocks run, 0.1 s after its begin at the latest.
  static constexpr std::uint32_t kWatchdog_us = 2'000'000;

  BootBoard()
      : watchdog_(block<stm32g474::Iwdg>(stm32g474::kIWDG_BASE)),
        programs_(block<stm32g474::Flash>(stm32g474::kFLASH_BASE), part_, stm32g474::careful_read) {}

  void start() { static_cast<void>(watchdog_.start(stm32g474::plan_watchdog(kWatchdog_us))); }
  ProgramMemory& programs() { return programs_; }

  /// Enters the program whose vector table lies there.
  [[noreturn]] void run(std::uint32_t vectors) {
    watchdog_.refresh();
    cortex_m::enter_program(vectors);
  }

  /// There is no program: the LED is lit, the outputs stay safe, until somebody flashes one.
  [[noreturn]] void stay() {
    stm32g474::set_bits(block<stm32g474::Rcc>(stm32g474::kRCC_BASE).ahb2enr,
                        stm32g474::kRCC_AHB2ENR_GPIOAEN(1));
    auto& a = block<stm32g474::Gpio>(stm32g474::kGPIOA_BASE);
    stm32g474::set_up_pin(a, {.pin = kLedPin, .mode = stm32g474::PinMode::kOutput});
    a.bsrr = 1U << kLedPin;
    for (;;) watchdog_.refresh();
  }

 private:
  static constexpr std::uint32_t kLedPin = 5;  // PA5, LD2
  using Part = stm32g474::Part;
  using FlashBlock = stm32g474::Flash<Part::Word>;

  template <template <class> class Block>
  static Block<Part::Word>& block(std::uint32_t address) {
    return Part::block<Block>(address);
  }

  Part part_;
  stm32g474::IndependentWatchdog<stm32g474::Iwdg<Part::Word>> watchdog_;
  stm32g474::ProgramFlash<Part, FlashBlock, Part> programs_;
};

}  // namespace slipstack
