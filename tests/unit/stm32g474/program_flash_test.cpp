// SPDX-License-Identifier: Apache-2.0
// Slots, notes and parameters at their places in the flash, register by register, and a whole update through
// them: the running program's bank is read and never erased or written.
#include "hal/stm32g474/program_flash.h"

#include <gtest/gtest.h>

#include <random>

#include "firmware/update/boot_choice.h"
#include "firmware/update/program_writer.h"
#include "firmware/update/trial_watch.h"
#include "tests/unit/stm32g474/simulated_flash.h"
#include "tests/unit/stm32g474/simulated_part.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimulatedFlash;
using test::SimulatedPart;
using test::SimWord;

constexpr std::uint32_t kSlot[2] = {0x08007000, 0x08047000};
using Slots = ProgramFlash<SimulatedPart::Access, Flash<SimWord>, SimulatedFlash::Memory>;

struct G474 {
  SimulatedPart part;
  SimulatedFlash flash;

  Slots slots_running_at(std::uint32_t vectors) {
    SimulatedPart::Access::word(0xE000ED08).value = vectors;
    return Slots(flash.registers, flash.memory, flash.careful);
  }
};

std::vector<std::byte> image_of(std::uint32_t address, const std::vector<std::byte>& program) {
  update::ImageHeader header;
  header.board = 0x34373447;
  header.address = address;
  header.size = static_cast<std::uint32_t>(program.size());
  header.crc = crc32(program);
  const update::HeaderBytes head = update::to_bytes(header);
  std::vector<std::byte> image(head.size() + program.size());
  std::copy(head.begin(), head.end(), image.begin());
  std::copy(program.begin(), program.end(), image.begin() + static_cast<std::ptrdiff_t>(head.size()));
  return image;
}

std::vector<std::byte> random_program(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

// Clears, loads and installs; an image for each slot in one file.
void update_to(ProgramMemory& memory, std::size_t size, unsigned seed) {
  std::vector<std::byte> file;
  for (const std::uint32_t address : kSlot) {
    for (const std::byte byte : image_of(address, random_program(size, seed + address))) file.push_back(byte);
  }
  update::ProgramWriter writer(memory);
  ASSERT_EQ(writer.clear(), update::UpdateFault::kNone);
  while (writer.clearing()) ASSERT_EQ(writer.step(), update::UpdateFault::kNone);
  ASSERT_EQ(writer.begin(), update::UpdateFault::kNone);
  for (std::size_t at = 0; at < file.size(); at += 7) {
    ASSERT_EQ(writer.write(std::span(file).subspan(at, std::min<std::size_t>(7, file.size() - at))),
              update::UpdateFault::kNone);
  }
  ASSERT_EQ(writer.finish(), update::UpdateFault::kNone);
  ASSERT_EQ(writer.install(), update::UpdateFault::kNone);
}

TEST(ProgramFlash, KnowsWhichSlotRuns) {
  G474 board;
  EXPECT_EQ(board.slots_running_at(0x08007200).running(), 0U);
  EXPECT_EQ(board.slots_running_at(0x08047200).running(), 1U);
  EXPECT_EQ(board.slots_running_at(0x08000000).running(), 0U);
  EXPECT_EQ(board.slots_running_at(0).running(), 0U);
  EXPECT_EQ(board.slots_running_at(0x20000000).running(), 0U);
  Slots slots = board.slots_running_at(0x08007200);
  EXPECT_EQ(slots.address(0), kSlot[0]);
  EXPECT_EQ(slots.address(1), kSlot[1]);
  EXPECT_EQ(slots.program(0).page_count() * slots.program(0).page_size(), 224U * 1024U);
}

TEST(ProgramFlash, NotesLieInTheOtherBank) {
  G474 board;
  Slots slots = board.slots_running_at(0x08007200);
  ASSERT_EQ(slots.notes(0).erase(0), NonvolatileStatus::kOk);
  ASSERT_EQ(slots.notes(1).erase(0), NonvolatileStatus::kOk);
  EXPECT_EQ(board.flash.erased_pages, (std::vector<std::uint32_t>{128 + 13, 13}));
}

TEST(ProgramFlash, ARestartSwitchesThePowerStageOffFirst) {
  G474 board;
  SimulatedPart::Access::block<Gpio>(kGPIOB_BASE);
  Slots slots = board.slots_running_at(0x08007200);
  slots.restart();
  EXPECT_EQ(SimulatedPart::Access::word(0xE000ED0C).value, 0x05FA0004U);
  EXPECT_TRUE(board.part.amplifier().enable_driven);
  EXPECT_FALSE(board.part.amplifier().enabled);
}

TEST(ProgramFlash, AWholeUpdateWritesTheOtherBankOnly) {
  for (const std::uint32_t bank : {0U, 1U}) {
    G474 board;
    Slots slots = board.slots_running_at(kSlot[bank] + 0x200);
    std::fill(board.flash.words.begin(), board.flash.words.end(), 0x12345678);  // what was there before
    const std::uint32_t other = bank ^ 1U;
    const std::vector<std::uint32_t> before = board.flash.words;
    update_to(slots, 5001, 3);
    EXPECT_EQ(board.flash.written_banks, std::set<std::uint32_t>{other});
    // Pages 14 to 125 of the other bank: neither boot loader nor notes nor parameters.
    std::vector<std::uint32_t> pages;
    for (std::uint32_t page = 14; page < 126; ++page) pages.push_back(128 * other + page);
    EXPECT_EQ(board.flash.erased_pages, pages);
    for (std::uint32_t page = 0; page < 256; ++page) {
      if (page >= 128 * other + 14 && page < 128 * other + 126) continue;
      for (std::uint32_t i = 512 * page; i < 512 * (page + 1); ++i)
        ASSERT_EQ(board.flash.words[i], before[i]) << page;
    }
    board.flash.expect_at_rest();
  }
}

// The boot loader on the same flash: new board, update, torn word in the new program.
TEST(ProgramFlash, TheBootLoaderStartsTheUpdateAndNotWhatIsTorn) {
  G474 board;
  Slots first = board.slots_running_at(kSlot[1] + 0x200);  // as if slot 2 had flashed slot 1
  update_to(first, 3000, 1);
  Slots boot = board.slots_running_at(0x08000000);
  EXPECT_EQ(update::decide(boot), 0U);
  Slots running = board.slots_running_at(kSlot[0] + 0x200);
  update::TrialWatch watch(running);
  for (std::uint32_t now_us = 0; now_us <= 5'000'000; now_us += 1000) watch.step(now_us, true, true);
  ASSERT_EQ(watch.state(), update::SlotState::kConfirmed);
  update_to(running, 4000, 2);
  EXPECT_EQ(update::decide(boot), 1U);
  board.flash.torn.insert(kSlot[1] + 512 + 2000);
  EXPECT_EQ(update::decide(boot), 0U);
  board.flash.torn.clear();
  board.flash.torn.insert(kSlot[1] + 64);
  EXPECT_EQ(update::decide(boot), 0U) << "the number of the install cannot be read";
  board.flash.expect_at_rest();
}

}  // namespace
}  // namespace slipstack::stm32g474
