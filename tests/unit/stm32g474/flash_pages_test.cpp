// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/flash_pages.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

constexpr std::uint32_t kPage[2] = {0x0807F000, 0x0807F800};

// The flash interface and the two last pages of bank 2, as RM0440 describes them.
struct SimFlash {
  Flash<SimWord> registers;
  CarefulRead careful;
  std::vector<std::uint32_t> words = std::vector<std::uint32_t>(1024, 0xFFFFFFFF);
  std::set<std::uint32_t> torn;       // double words whose code is wrong
  std::set<std::uint32_t> read_only;  // double words that do not take what is written
  std::uint32_t keys = 0;
  bool key_works = true;
  std::uint32_t busy_reads = 0;
  std::uint32_t busy_for = 3;
  bool stuck = false;
  bool erases = true;
  std::uint32_t error_at_end = 0;  // an error flag that the next command raises
  std::vector<std::uint32_t> erased_pages;
  std::uint32_t programmed = 0;
  bool misused = false;
  bool cached_access = false;
  bool unexpected_nmi = false;
  bool half = false;
  std::uint32_t half_address = 0;
  std::uint32_t half_word = 0;

  struct Memory {
    SimFlash& flash;
    std::uint32_t read_word(std::uint32_t address) { return flash.read_word(address); }
    void write_word(std::uint32_t address, std::uint32_t value) { flash.write_word(address, value); }
  } memory{*this};
  FlashPages<Flash<SimWord>, Memory> pages{registers, memory, careful};

  SimFlash() {
    registers.acr.value = 0x704;
    registers.optr.value = 1U << 22U;
    registers.cr.value = 0xC0000000;
    registers.keyr.on_write = [this](SimWord&, std::uint32_t written) {
      if (keys == 0 && written == 0x45670123) {
        keys = 1;
      } else if (keys == 1 && written == 0xCDEF89AB && key_works) {
        registers.cr.value &= ~(1U << 31U);
        keys = 0;
      } else if (key_works) {
        misused = true;  // the part would fault and stay locked until reset
      }
    };
    registers.cr.on_write = [this](SimWord& self, std::uint32_t written) {
      if ((self.value >> 31U) != 0 && written != self.value) {
        misused = true;
        return;
      }
      if (busy_reads > 0) misused = true;
      self.value = written & ~(1U << 16U);
      if ((written & (1U << 16U)) != 0) erase(written);
    };
    registers.sr.on_read = [this](std::uint32_t value) {
      if (stuck) return value | 1U << 16U;
      if (busy_reads > 0) {
        --busy_reads;
        return value | 1U << 16U;
      }
      return value;
    };
    registers.sr.on_write = [](SimWord& self, std::uint32_t written) { self.value &= ~written; };
    registers.eccr.on_write = [](SimWord& self, std::uint32_t written) {
      self.value &= ~(written & 0xF0000000U);
    };
  }

  void finish() {
    busy_reads = busy_for;
    registers.sr.value |= error_at_end != 0 ? error_at_end : 1U;
  }

  void erase(std::uint32_t command) {
    if ((command & 2U) == 0 || (registers.acr.value & (1U << 10U)) != 0) misused = true;
    const std::uint32_t page = command >> 3U & 0x7FU;
    EXPECT_NE(command & (1U << 11U), 0U) << "bank 1 holds the program";
    erased_pages.push_back(page);
    if (page >= 126 && erases && error_at_end == 0) {
      for (std::uint32_t i = 0; i < 512; ++i) words[(page - 126) * 512 + i] = 0xFFFFFFFF;
      for (std::uint32_t i = 0; i < 256; ++i) torn.erase(kPage[page - 126] + 8 * i);
    }
    finish();
  }

  std::uint32_t& word_at(std::uint32_t address) { return words.at((address - kPage[0]) / 4); }

  std::uint32_t read_word(std::uint32_t address) {
    EXPECT_EQ(address % 4, 0U);
    if ((registers.acr.value & (1U << 10U)) != 0) cached_access = true;
    if (torn.contains(address & ~7U)) {
      registers.eccr.value |= 1U << 31U;
      if (!on_flash_nmi(registers, careful)) unexpected_nmi = true;
    }
    return word_at(address);
  }

  void write_word(std::uint32_t address, std::uint32_t value) {
    if ((registers.cr.value & 1U) == 0 || busy_reads > 0) misused = true;
    if (!half) {
      if (address % 8 != 0) misused = true;
      half = true;
      half_address = address;
      half_word = value;
      return;
    }
    half = false;
    if (address != half_address + 4) misused = true;
    ++programmed;
    const bool blank =
        word_at(half_address) == 0xFFFFFFFF && word_at(address) == 0xFFFFFFFF && !torn.contains(half_address);
    if (!blank && (half_word != 0 || value != 0)) {
      registers.sr.value |= 1U << 3U;  // PROGERR
    } else if (error_at_end == 0 && !read_only.contains(half_address)) {
      word_at(half_address) = half_word;
      word_at(address) = value;
    }
    finish();
  }

  void expect_at_rest() const {
    EXPECT_FALSE(misused);
    EXPECT_FALSE(cached_access);
    EXPECT_FALSE(unexpected_nmi);
    EXPECT_EQ(registers.acr.value, 0x704U) << "the cache must be back as it was";
    EXPECT_FALSE(careful.reading);
  }
};

std::vector<std::byte> random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

TEST(FlashPages, AreTheLastTwoOfTheFlash) {
  static_assert(kParameterBegin == 0x0807F000);
  SimFlash flash;
  EXPECT_EQ(flash.pages.page_count(), 2U);
  EXPECT_EQ(flash.pages.page_size(), 2048U);
  EXPECT_EQ(flash.pages.write_unit(), 8U);
}

TEST(FlashPages, KeepWhatIsWritten) {
  SimFlash flash;
  const auto bytes = random_bytes(2048, 7);
  ASSERT_EQ(flash.pages.write(1, 0, bytes), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.programmed, 256U);
  std::mt19937 random(8);
  for (int i = 0; i < 500; ++i) {
    const std::size_t offset = random() % 2049;
    std::vector<std::byte> out(random() % (2049 - offset));
    ASSERT_EQ(flash.pages.read(1, offset, out), NonvolatileStatus::kOk);
    ASSERT_TRUE(std::equal(out.begin(), out.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset)));
  }
  std::vector<std::byte> other(2048);
  ASSERT_EQ(flash.pages.read(0, 0, other), NonvolatileStatus::kOk);
  EXPECT_TRUE(std::all_of(other.begin(), other.end(), [](std::byte b) { return b == std::byte{0xFF}; }));
  EXPECT_NE(flash.registers.cr.value & (1U << 31U), 0U) << "locked again";
  flash.expect_at_rest();
}

TEST(FlashPages, EraseTheirOwnPageOnly) {
  SimFlash flash;
  std::fill(flash.words.begin(), flash.words.end(), 0x12345678);
  ASSERT_EQ(flash.pages.erase(0), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.erased_pages, std::vector<std::uint32_t>{126});
  EXPECT_EQ(flash.words[511], 0xFFFFFFFFU);
  EXPECT_EQ(flash.words[512], 0x12345678U);
  ASSERT_EQ(flash.pages.erase(1), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.erased_pages.back(), 127U);
  EXPECT_EQ(flash.words[512], 0xFFFFFFFFU);
  EXPECT_NE(flash.registers.cr.value & (1U << 31U), 0U);
  flash.expect_at_rest();
}

TEST(FlashPages, RefuseWhatIsOutsideOrCrooked) {
  SimFlash flash;
  std::vector<std::byte> bytes(8);
  EXPECT_EQ(flash.pages.erase(2), NonvolatileStatus::kOutOfRange);
  EXPECT_EQ(flash.pages.write(2, 0, bytes), NonvolatileStatus::kOutOfRange);
  EXPECT_EQ(flash.pages.write(0, 2048, bytes), NonvolatileStatus::kOutOfRange);
  EXPECT_EQ(flash.pages.write(0, SIZE_MAX - 3, bytes), NonvolatileStatus::kOutOfRange);
  EXPECT_EQ(flash.pages.read(0, 2041, bytes), NonvolatileStatus::kOutOfRange);
  EXPECT_EQ(flash.pages.write(0, 4, bytes), NonvolatileStatus::kMisaligned);
  EXPECT_EQ(flash.pages.write(0, 0, std::span(bytes).first(4)), NonvolatileStatus::kMisaligned);
  EXPECT_EQ(flash.pages.write(0, 0, {}), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.programmed, 0U);
  flash.expect_at_rest();
}

TEST(FlashPages, DoNotWriteWhatIsNotErased) {
  SimFlash flash;
  flash.word_at(kPage[0] + 12) = 0xFFFFFFFE;
  EXPECT_EQ(flash.pages.write(0, 0, random_bytes(16, 1)), NonvolatileStatus::kNotErased);
  EXPECT_EQ(flash.pages.write(0, 0, random_bytes(8, 1)), NonvolatileStatus::kOk);
  flash.torn.insert(kPage[1] + 8);
  EXPECT_EQ(flash.pages.write(1, 0, random_bytes(16, 1)), NonvolatileStatus::kNotErased);
  EXPECT_EQ(flash.programmed, 1U);
  flash.expect_at_rest();
}

TEST(FlashPages, ReportEveryErrorOfTheDevice) {
  // OPERR, PROGERR, WRPERR, PGAERR, SIZERR, PGSERR, MISERR, FASTERR, RDERR, OPTVERR
  for (const std::uint32_t bit : {1U, 3U, 4U, 5U, 6U, 7U, 8U, 9U, 14U, 15U}) {
    SimFlash flash;
    flash.error_at_end = 1U << bit;
    EXPECT_EQ(flash.pages.write(0, 0, random_bytes(24, 1)), NonvolatileStatus::kDeviceError) << bit;
    EXPECT_EQ(flash.programmed, 1U) << "stops at the first";
    EXPECT_EQ(flash.pages.erase(0), NonvolatileStatus::kDeviceError) << bit;
    EXPECT_EQ(flash.registers.sr.value, 0U) << "an old error would forbid the next command";
    flash.error_at_end = 0;
    EXPECT_EQ(flash.pages.write(0, 0, random_bytes(24, 1)), NonvolatileStatus::kOk) << bit;
    EXPECT_NE(flash.registers.cr.value & (1U << 31U), 0U);
    flash.expect_at_rest();
  }
}

TEST(FlashPages, ReadBackWhatTheyWriteAndErase) {
  SimFlash flash;
  flash.read_only.insert(kPage[0] + 8);
  EXPECT_EQ(flash.pages.write(0, 0, random_bytes(8, 1)), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.pages.write(0, 8, random_bytes(8, 1)), NonvolatileStatus::kDeviceError);
  flash.erases = false;
  EXPECT_EQ(flash.pages.erase(0), NonvolatileStatus::kDeviceError);
  flash.expect_at_rest();
}

TEST(FlashPages, DoNotHangOnADeviceThatStaysBusy) {
  SimFlash flash;
  flash.stuck = true;
  EXPECT_EQ(flash.pages.erase(0), NonvolatileStatus::kDeviceError);
  EXPECT_TRUE(flash.erased_pages.empty());
  flash.expect_at_rest();
}

TEST(FlashPages, RefuseALockedDeviceAndSingleBankMode) {
  SimFlash locked;
  locked.key_works = false;
  EXPECT_EQ(locked.pages.erase(0), NonvolatileStatus::kDeviceError);
  EXPECT_EQ(locked.pages.write(0, 0, random_bytes(8, 1)), NonvolatileStatus::kDeviceError);
  EXPECT_EQ(locked.programmed, 0U);

  SimFlash single;  // pages of 4 KiB: this number would be another page
  single.registers.optr.value = 0;
  EXPECT_EQ(single.pages.erase(0), NonvolatileStatus::kDeviceError);
  EXPECT_TRUE(single.erased_pages.empty());
}

// Power failed while 8 bytes were written: the rest of the page stays readable, these are reported, nothing
// faults.
TEST(FlashPages, SurviveAHalfWrittenWord) {
  SimFlash flash;
  const auto bytes = random_bytes(64, 3);
  ASSERT_EQ(flash.pages.write(0, 0, bytes), NonvolatileStatus::kOk);
  flash.torn.insert(kPage[0] + 16);
  std::vector<std::byte> out(8);
  for (std::size_t offset = 0; offset < 64; offset += 8) {
    const bool bad = offset == 16;
    EXPECT_EQ(flash.pages.read(0, offset, out),
              bad ? NonvolatileStatus::kDeviceError : NonvolatileStatus::kOk)
        << offset;
  }
  std::vector<std::byte> all(64);
  EXPECT_EQ(flash.pages.read(0, 0, all), NonvolatileStatus::kDeviceError);
  EXPECT_EQ(flash.registers.eccr.value, 0U);
  EXPECT_EQ(flash.pages.erase(0), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.pages.read(0, 0, all), NonvolatileStatus::kOk);
  flash.expect_at_rest();
}

TEST(FlashPages, AnUnannouncedErrorIsAFault) {
  SimFlash flash;
  flash.registers.eccr.value = 1U << 31U;
  EXPECT_FALSE(on_flash_nmi(flash.registers, flash.careful));
  EXPECT_EQ(flash.registers.eccr.value, 1U << 31U);
  flash.registers.eccr.value = 0;
  flash.careful.reading = true;  // the NMI has another cause: the crystal
  EXPECT_FALSE(on_flash_nmi(flash.registers, flash.careful));
}

TEST(FlashPages, LeaveACacheOffThatWasOff) {
  SimFlash flash;
  flash.registers.acr.value = 0x304;
  ASSERT_EQ(flash.pages.erase(0), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.registers.acr.value, 0x304U);
}

}  // namespace
}  // namespace slipstack::stm32g474
