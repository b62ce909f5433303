// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// What every Cortex-M4F or M7 image does between reset and main(). For the one source of a board that holds
// its vectors: it defines start_program(), which reset_handler() enters with the FPU on.

extern "C" {
// From the board's linker script in toolchain/ld.
extern std::uint32_t __data_load[], __data_begin[], __data_end[];  // NOLINT(bugprone-reserved-identifier)
extern std::uint32_t __bss_begin[], __bss_end[];                   // NOLINT(bugprone-reserved-identifier)
extern std::uint32_t __stack_top[];                                // NOLINT(bugprone-reserved-identifier)
using Constructor = void (*)();
extern Constructor __init_array_begin[], __init_array_end[];  // NOLINT(bugprone-reserved-identifier)

[[noreturn]] void start_program();

// How the FPU computes, of main and of every exception: round to nearest, denormals kept, no default NaN, as
// the host does. Armv7-M Architecture Reference Manual: FPSCR A2.5.3, FPDSCR B3.2.24 (what an exception finds
// in FPSCR). Another value only in the image that shows what the tests see (tests/budget).
#ifndef SLIPSTACK_FPU_MODE
#define SLIPSTACK_FPU_MODE 0
#endif

// The FPU is off after reset, and a prologue that saves its registers would fault: no prologue here.
// CPACR, CP10 and CP11 full access: Armv7-M Architecture Reference Manual, B3.2.20.
__attribute__((naked, noreturn, used)) inline void reset_handler() {
  asm volatile(
      "ldr r0, =0xE000ED88 \n"
      "ldr r1, [r0]        \n"
      "orr r1, #0xF00000   \n"
      "str r1, [r0]        \n"
      "dsb                 \n"
      "isb                 \n"
      "ldr r0, =0xE000EF3C \n"
      "ldr r1, =%0         \n"
      "str r1, [r0]        \n"
      "vmsr fpscr, r1      \n"
      "b start_program     \n" ::"i"(SLIPSTACK_FPU_MODE));
}
}

namespace slipstack::cortex_m {

/// Fills RAM. Word loops of our own: memcpy may be compiled to use what is not ready yet.
__attribute__((noinline, optimize("no-tree-loop-distribute-patterns"))) inline void fill_memory() {
  const std::uint32_t* from = __data_load;
  for (std::uint32_t* to = __data_begin; to < __data_end; ++to, ++from) *to = *from;
  for (std::uint32_t* to = __bss_begin; to < __bss_end; ++to) *to = 0;
}

/// Runs the constructors of static objects, in the linker's order.
inline void run_constructors() {
  for (const Constructor* constructor = __init_array_begin; constructor < __init_array_end; ++constructor) {
    (*constructor)();
  }
}

}  // namespace slipstack::cortex_m
