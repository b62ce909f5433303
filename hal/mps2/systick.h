// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// The 24-bit down-counter of the processor (Armv7-M Architecture Reference Manual, B3.3), 25 MHz on the MPS2.
// In QEMU started with `-icount shift=10` an instruction takes 1024 ns, so that the counter falls by 25.6 per
// instruction, whatever the instruction: it counts instructions, not time.
namespace slipstack::mps2 {

inline constexpr std::uint32_t kSystickMask = 0x00FFFFFF;

namespace detail {
inline volatile std::uint32_t& systick_word(std::uint32_t offset) {
  return *reinterpret_cast<volatile std::uint32_t*>(0xE000E010U + offset);
}
}  // namespace detail

// Starts the counter free-running over all its 24 bits, without interrupt.
inline void systick_start_free() {
  detail::systick_word(4) = kSystickMask;
  detail::systick_word(8) = 0;
  detail::systick_word(0) = 0x5;  // processor clock, enabled
}

inline std::uint32_t systick_now() {
  return detail::systick_word(8);
}

// Starts the counter with a period of `counts`, 2 to 2^24, and its exception at the end of each.
inline void systick_start_periodic(std::uint32_t counts) {
  detail::systick_word(4) = counts - 1;
  detail::systick_word(8) = 0;
  detail::systick_word(0) = 0x7;  // processor clock, exception, enabled
}

inline void systick_stop() {
  detail::systick_word(0) = 0x4;
}

// Counts from `begin` to `end`, both read with systick_now(), less than 2^24 apart.
inline std::uint32_t systick_elapsed(std::uint32_t begin, std::uint32_t end) {
  return (begin - end) & kSystickMask;
}

}  // namespace slipstack::mps2
