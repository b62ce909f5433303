// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/include/program_memory.h"
#include "hal/stm32g474/flash_map.h"
#include "hal/stm32g474/flash_pages.h"
#include "hal/stm32g474/safe_outputs.h"

namespace slipstack::stm32g474 {

inline constexpr std::uint32_t kBoardId = 0x34373447;  // "G474"
inline constexpr std::uint32_t kVectorTable =
    0xE000ED08;  // VTOR: Armv7-M Architecture Reference Manual, B3.2.5
inline constexpr std::uint32_t kResetControl = 0xE000ED0C;  // AIRCR: B3.2.6

// The two slots and the notes about them. The running program is that of the bank in which its vector table
// lies. Hardware: the part, or a simulated one.
template <class Hardware, class FlashBlock, class Memory>
class ProgramFlash final : public ProgramMemory {
 public:
  ProgramFlash(FlashBlock& flash, Memory& memory, CarefulRead& careful)
      : running_(bank_of(Hardware::word(kVectorTable))),
        programs_{Pages(flash, memory, careful, slot_in(0)), Pages(flash, memory, careful, slot_in(1))},
        notes_{Pages(flash, memory, careful, notes_in(1)), Pages(flash, memory, careful, notes_in(0))} {}

  std::size_t running() const override { return running_; }
  std::uint32_t board() const override { return kBoardId; }
  std::uint32_t address(std::size_t slot) const override {
    return slot_in(static_cast<std::uint32_t>(slot)).begin();
  }
  const Nonvolatile& program(std::size_t slot) const override { return programs_[slot]; }
  Nonvolatile& spare() override { return programs_[running_ ^ 1U]; }
  Nonvolatile& notes(std::size_t slot) override { return notes_[slot]; }
  void restart() override {
    secure_outputs<Hardware>();
    Hardware::word(kResetControl) = 0x05FA0004;  // the key, and SYSRESETREQ
  }

 private:
  using Pages = FlashPages<FlashBlock, Memory>;

  std::size_t running_;
  std::array<Pages, kSlots> programs_;
  std::array<Pages, kSlots> notes_;  // by slot: in the other bank
};

}  // namespace slipstack::stm32g474
