// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/stm32g474/core.h"
#include "hal/stm32g474/registers.h"

// The blocks at their addresses: only what runs on the part includes this.
namespace slipstack::stm32g474 {

using HardwareWord = volatile std::uint32_t;

// The block that lies at `address`.
template <template <class> class Block>
Block<HardwareWord>& hardware(std::uint32_t address) {
  return *reinterpret_cast<Block<HardwareWord>*>(address);
}

inline HardwareWord& hardware_word(std::uint32_t address) {
  return *reinterpret_cast<HardwareWord*>(address);
}

// Waits at least `cycles` cycles of the core; an interrupt makes it longer.
inline void wait_cycles(std::uint32_t cycles) {
  // A turn takes at least 3 cycles: decrement, branch taken (Cortex-M4 TRM, 3.3.1).
  for (std::uint32_t turns = cycles / 3 + 1; turns > 0; --turns) asm volatile("");
}

// Waits at least that long at the full core clock, longer at a slower one.
inline void wait_us(std::uint32_t duration_us) {
  wait_cycles(170 * duration_us);
}

// The part, for Board: its blocks, its words of the core, its memory bus, and time. Host tests have a
// simulated one.
struct Part {
  using Word = HardwareWord;

  template <template <class> class Block>
  static Block<Word>& block(std::uint32_t address) {
    return hardware<Block>(address);
  }
  static Word& word(std::uint32_t address) { return hardware_word(address); }
  static void wait_us(std::uint32_t duration_us) { stm32g474::wait_us(duration_us); }

  // The barriers let the NMI of a bad word come before the next instruction.
  std::uint32_t read_word(std::uint32_t address) const {
    const std::uint32_t word = hardware_word(address);
    asm volatile("dsb \n isb \n nop \n nop" ::: "memory");
    return word;
  }
  void write_word(std::uint32_t address, std::uint32_t value) const { hardware_word(address) = value; }
};

}  // namespace slipstack::stm32g474
