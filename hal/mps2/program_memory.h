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
#include "hal/mps2/program_map.h"
#include "hal/mps2/semihosting.h"

namespace slipstack::mps2 {

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

  static FlashSupply& supply() { return *reinterpret_cast<FlashSupply*>(kProgramSupply); }

  std::size_t running() const override { return running_; }
  std::uint32_t board() const override { return kBoardId; }
  std::uint32_t address(std::size_t slot) const override {
    return program_page(static_cast<std::uint32_t>(slot), kSlotPage);
  }
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
  std::size_t running_;
  std::array<ProgramPages, 2> slots_{ProgramPages{program_page(0, kSlotPage), kSlotPages, supply()},
                                     ProgramPages{program_page(1, kSlotPage), kSlotPages, supply()}};
  std::array<ProgramPages, 2> notes_{ProgramPages{program_page(1, kNotesPage), 1, supply()},
                                     ProgramPages{program_page(0, kNotesPage), 1, supply()}};
};

}  // namespace slipstack::mps2
