// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack::mps2 {

/// Program flash emulated in the PSRAM, which a file of the host's backs: it survives a reset of the
/// processor and the end of the emulator. Laid out as a bank of the NUCLEO-G474RE twice
/// (hal/stm32g474/flash_map.h). toolchain/ld/mps2-an386*.ld and tests/boot/check_boot.py name the same
/// addresses; tests/unit/mps2/program_map_test.cpp compares them.
inline constexpr std::uint32_t kPsram = 0x21000000;
inline constexpr std::uint32_t kPsramBytes = 16U << 20;
inline constexpr std::uint32_t kProgramFlash = 0x21800000;
inline constexpr std::uint32_t kProgramPageBytes = 2048;
inline constexpr std::uint32_t kProgramBankBytes = 128 * kProgramPageBytes;
inline constexpr std::uint32_t kNotesPage = 13;
inline constexpr std::uint32_t kSlotPage = 14;
inline constexpr std::uint32_t kSlotPages = 112;
/// Behind the two banks; the supply of the flash (FlashSupply).
inline constexpr std::uint32_t kProgramSupply = kProgramFlash + 2 * kProgramBankBytes;

/// A page of a bank.
constexpr std::uint32_t program_page(std::uint32_t bank, std::uint32_t page) {
  return kProgramFlash + bank * kProgramBankBytes + page * kProgramPageBytes;
}

}  // namespace slipstack::mps2
