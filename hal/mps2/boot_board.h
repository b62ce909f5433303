// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/cortex_m/enter_program.h"
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

  /// Enters the program whose vector table lies there.
  [[noreturn]] void run(std::uint32_t vectors) { cortex_m::enter_program(vectors); }

  [[noreturn]] void stay() {
    mps2::uart_write("no program\n");
    mps2::exit_emulator(kExitNoProgram);
  }

 private:
  mps2::EmulatedProgramMemory programs_{0};
};

}  // namespace slipstack
