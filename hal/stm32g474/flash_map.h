// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// What lies where in the 512 KiB of flash: two banks of the same layout (docs/firmware-update.md has the
// drawing; toolchain/ld the same addresses). RM0440, Embedded flash memory (FLASH) for category 3 devices:
// while one bank is erased or written, the processor goes on in the other.
namespace slipstack::stm32g474 {

inline constexpr std::uint32_t kFlashBegin = 0x08000000;
inline constexpr std::uint32_t kFlashBytes = 512 * 1024;
inline constexpr std::uint32_t kFlashPageBytes = 2048;
inline constexpr std::uint32_t kFlashPagesPerBank = 128;
inline constexpr std::uint32_t kFlashBankBytes = kFlashPagesPerBank * kFlashPageBytes;

/// Pages that belong together, in one bank.
struct FlashRegion {
  std::uint32_t bank;
  std::uint32_t first_page;
  std::uint32_t pages;

  constexpr std::uint32_t begin() const {
    return kFlashBegin + bank * kFlashBankBytes + first_page * kFlashPageBytes;
  }
};

// Of bank 1; the same pages of bank 2 are not used.
inline constexpr FlashRegion kBootLoader{0, 0, 13};
/// Notes about the program in the other bank, which writes them.
constexpr FlashRegion notes_in(std::uint32_t bank) {
  return {bank, 13, 1};
}
/// Header block and program.
constexpr FlashRegion slot_in(std::uint32_t bank) {
  return {bank, 14, 112};
}
/// Parameters of the program in the other bank.
constexpr FlashRegion parameters_in(std::uint32_t bank) {
  return {bank, 126, 2};
}

static_assert(kBootLoader.pages == notes_in(0).first_page &&
                  notes_in(0).first_page + notes_in(0).pages == slot_in(0).first_page &&
                  slot_in(0).first_page + slot_in(0).pages == parameters_in(0).first_page &&
                  parameters_in(0).first_page + parameters_in(0).pages == kFlashPagesPerBank,
              "the regions fill a bank, and none overlaps another");

/// In which bank a program runs, by its vector table.
constexpr std::uint32_t bank_of(std::uint32_t address) {
  return address >= kFlashBegin + kFlashBankBytes && address < kFlashBegin + kFlashBytes ? 1 : 0;
}

}  // namespace slipstack::stm32g474
