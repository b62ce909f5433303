// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "hal/include/program_memory.h"
#include "hal/mps2/memory_pages.h"
#include "hal/mps2/semihosting.h"

namespace slipstack::mps2 {

/// Program flash emulated in the PSRAM, which a file of the host's backs: it survives a reset of the
/// processor and the end of the emulator. Laid out as a bank of the NUCLEO-G474RE twice
/// (hal/stm32g474/flash_map.h); toolchain/ld/mps2-an386_slot1.ld and _slot2.ld and tests/boot hold the same
/// addresses.
inline constexpr std::uint32_t kProgramFlash = 0x21800000;
inline constexpr std::uint32_t kProgramPageBytes = 2048;
inline constexpr std::uint32_t kProgramBankBytes = 128 * kProgramPageBytes;
inline constexpr std::uint32_t kNotesPage = 13;
inline constexpr std::uint32_t kSlotPage = 14;
inline constexpr std::uint32_t kSlotPages = 112;

/// The supply of the emulated flash; behind the two banks. The host sets after how many writes and erasures
/// it fails; 0: never.
struct FlashSupply {
  volatile std::uint32_t operations_left;
  volatile std::uint32_t operations;  ///< so many there were

  static constexpr int kExitCut = 75;  ///< the emulator's status when the supply has failed

  /// Before an operation: whether it is the one during which the supply fails.
  bool fails() {
    operations = operations + 1;
    if (operations_left == 0) return false;
    operations_left = operations_left - 1;
    return operations_left == 0;
  }
};

/// Pages of that flash. When the supply fails a write or an erasure is left half done, in the middle of a
/// unit.
class ProgramPages final : public MemoryFlashPages {
 public:
  ProgramPages(std::uint32_t address, std::size_t pages, FlashSupply& supply)
      : MemoryFlashPages(reinterpret_cast<std::byte*>(address), pages, kProgramPageBytes), supply_(supply) {}

  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (writable(page, offset, data.size()) == NonvolatileStatus::kOk && supply_.fails()) {
      std::copy_n(data.begin(), data.size() / 2 - kUnit / 4, at(page, offset));
      exit_emulator(FlashSupply::kExitCut);
    }
    return MemoryFlashPages::write(page, offset, data);
  }
  NonvolatileStatus erase(std::size_t page) override {
    if (page < page_count() && supply_.fails()) {
      std::memset(at(page, 0), 0xFF, kProgramPageBytes / 2 - kUnit / 4);
      exit_emulator(FlashSupply::kExitCut);
    }
    return MemoryFlashPages::erase(page);
  }

 private:
  FlashSupply& supply_;
};

/// The two slots of the emulated board. Notes about a slot lie in the other bank, as on the part.
class EmulatedProgramMemory final : public ProgramMemory {
 public:
  static constexpr std::uint32_t kBoardId = 0x3253504D;  // "MPS2"

  /// `running`: the slot of the program that uses it; of no meaning in the boot loader.
  explicit EmulatedProgramMemory(std::size_t running) : running_(running) {}

  static FlashSupply& supply() {
    return *reinterpret_cast<FlashSupply*>(kProgramFlash + 2 * kProgramBankBytes);
  }

  std::size_t running() const override { return running_; }
  std::uint32_t board() const override { return kBoardId; }
  std::uint32_t address(std::size_t slot) const override { return in_bank(slot, kSlotPage); }
  const Nonvolatile& program(std::size_t slot) const override { return slots_[slot]; }
  Nonvolatile& spare() override { return slots_[running_ ^ 1U]; }
  Nonvolatile& notes(std::size_t slot) override { return notes_[slot]; }
  /// SYSRESETREQ: Armv7-M Architecture Reference Manual, B3.2.6.
  void restart() override {
    asm volatile("dsb" ::: "memory");
    *reinterpret_cast<volatile std::uint32_t*>(0xE000ED0CU) = 0x05FA0004U;
    for (;;) asm volatile("");
  }

 private:
  static constexpr std::uint32_t in_bank(std::size_t bank, std::uint32_t page) {
    return kProgramFlash + static_cast<std::uint32_t>(bank) * kProgramBankBytes + page * kProgramPageBytes;
  }

  std::size_t running_;
  std::array<ProgramPages, 2> slots_{ProgramPages{in_bank(0, kSlotPage), kSlotPages, supply()},
                                     ProgramPages{in_bank(1, kSlotPage), kSlotPages, supply()}};
  std::array<ProgramPages, 2> notes_{ProgramPages{in_bank(1, kNotesPage), 1, supply()},
                                     ProgramPages{in_bank(0, kNotesPage), 1, supply()}};
};

}  // namespace slipstack::mps2
