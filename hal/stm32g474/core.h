// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/stm32g474/registers.h"

// What the drivers use of the Cortex-M4 itself. Reference: Armv7-M Architecture Reference Manual, DDI 0403E.
namespace slipstack::stm32g474 {

// The STM32G474 has 4 bits of priority (RM0440, Nested vectored interrupt controller): 16 levels, 0 the most
// urgent.
inline constexpr std::uint32_t kPriorityLevels = 16;

// B3.4, Nested Vectored Interrupt Controller.
template <class Word>
struct Nvic {
  Word iser[8];  // set-enable, 0xE000E100
  Word reserved_20[24];
  Word icer[8];  // clear-enable, 0xE000E180
  Word reserved_a0[24];
  Word ispr[8];  // set-pending, 0xE000E200
  Word reserved_120[24];
  Word icpr[8];  // clear-pending, 0xE000E280
  Word reserved_1a0[88];
  Word ipr[60];  // priorities, one byte each, 0xE000E400
};
static_assert(offsetof(Nvic<std::uint32_t>, icpr) == 0x180);
static_assert(offsetof(Nvic<std::uint32_t>, ipr) == 0x300);
inline constexpr std::uint32_t kNVIC_BASE = 0xE000E100;

// C1.8, Data Watchpoint and Trace unit: of it, the cycle counter.
template <class Word>
struct Dwt {
  Word ctrl;    // bit 0: CYCCNTENA
  Word cyccnt;  // cycles of the core, 32 bits
};
inline constexpr std::uint32_t kDWT_BASE = 0xE0001000;
inline constexpr std::uint32_t kDEMCR = 0xE000EDFC;  // bit 24: TRCENA, without which the DWT is off
inline constexpr std::uint32_t kAIRCR = 0xE000ED0C;  // B3.2.6: 0x05FA0004 asks for a reset

// Gives an interrupt its priority, 0 the most urgent, and switches it on.
template <class Word>
void enable_interrupt(Nvic<Word>& nvic, std::uint32_t number, std::uint32_t priority) {
  const std::uint32_t shift = 8 * (number % 4) + 4;  // the upper 4 bits of the byte
  change_bits(nvic.ipr[number / 4], 0xFFU << (8 * (number % 4)), (priority % kPriorityLevels) << shift);
  nvic.icpr[number / 32] = 1U << (number % 32);
  nvic.iser[number / 32] = 1U << (number % 32);
}

}  // namespace slipstack::stm32g474
