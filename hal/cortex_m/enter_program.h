// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack::cortex_m {

/// Enters the program whose vector table lies there, as a reset does: stack pointer, then reset vector. It
/// sets VTOR itself.
[[noreturn]] inline void enter_program(std::uint32_t vectors) {
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

}  // namespace slipstack::cortex_m
