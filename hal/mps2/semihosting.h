// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

// What an image asks of the emulator that runs it (Arm semihosting, started with
// `-semihosting-config enable=on,target=native`). For tests and measurements; a controller does not use it.
namespace slipstack::mps2 {

inline constexpr int kExitFault = 70;
inline constexpr int kExitAssertion = 71;

// Ends the emulator with this status, 0 to 255 (SYS_EXIT_EXTENDED). Without semihosting the processor faults.
[[noreturn]] void exit_emulator(int status);

// The emulator's `arg=` words, one space between them, as a string in `buffer` (SYS_GET_CMDLINE). Empty when
// they do not fit or there are none.
const char* command_line(std::span<char> buffer);

}  // namespace slipstack::mps2
