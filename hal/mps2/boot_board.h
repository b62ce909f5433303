// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/mps2/program_memory.h"
#include "hal/mps2/semihosting.h"
#include "hal/mps2/uart.h"

namespace slipstack {

/// The emulated board for firmware/app/boot_main.cpp: no outputs to be made safe, and no watchdog: the host
/// ends an emulator that hangs.
class BootBoard {
 public:
  static constexpr int kExitNoProgram = 76;  ///< the emulator's status where the part would light its LED

  void start() { mps2::uart_write("boot\n"); }
  ProgramMemory& programs() { return programs_; }

  /// Enters the program whose vector table lies there, as a reset does: stack pointer, then reset vector. It
  /// sets VTOR itself.
  [[noreturn]] void run(std::uint32_t vectors) {
    asm volatile(
        "ldr r1, [%0]     \n"
        "ldr r2, [%0, #4] \n"
        "msr msp, r1      \n"
        "dsb              \n"
        "isb              \n"
        "bx r2            \n" ::"r"(vectors)
        : "r1", "r2", "memory");
    __builtin_unreachable();
  }

  [[noreturn]] void stay() {
    mps2::uart_write("no program\n");
    mps2::exit_emulator(kExitNoProgram);
  }

 private:
  mps2::EmulatedProgramMemory programs_{0};
};

}  // namespace slipstack
