// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/flash_pages.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "tests/unit/stm32g474/simulated_flash.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

constexpr std::uint32_t kPage[2] = {0x0807F000, 0x0807F800};

struct SimFlash : test::SimulatedFlash {
  FlashPages<Flash<SimWord>, Memory> pages{registers, memory, careful, parameters_in(1)};
};

std::vector<std::byte> random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

TEST(FlashPages, AreTheLastTwoOfTheFlash) {
  static_assert(parameters_in(1).begin() == 0x0807F000);
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
  constexpr std::uint32_t kFirst = 254 * 512;
  std::fill(flash.words.begin(), flash.words.end(), 0x12345678);
  ASSERT_EQ(flash.pages.erase(0), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.erased_pages, std::vector<std::uint32_t>{254});
  EXPECT_EQ(flash.words[kFirst - 1], 0x12345678U);
  EXPECT_EQ(flash.words[kFirst + 511], 0xFFFFFFFFU);
  EXPECT_EQ(flash.words[kFirst + 512], 0x12345678U);
  ASSERT_EQ(flash.pages.erase(1), NonvolatileStatus::kOk);
  EXPECT_EQ(flash.erased_pages.back(), 255U);
  EXPECT_EQ(flash.words[kFirst + 512], 0xFFFFFFFFU);
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
