// SPDX-License-Identifier: Apache-2.0
#include "firmware/storage/record_slots.h"

#include <gtest/gtest.h>

#include <numeric>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "tests/unit/storage/cut_flash.h"

namespace slipstack {
namespace {

using test::Bytes;
using test::CutFlash;

Bytes pattern(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xFFU);
  return bytes;
}

std::optional<Bytes> newest(Nonvolatile& flash) {
  RecordSlots log(flash);
  if (log.mount() != StoreStatus::kOk) return std::nullopt;
  Bytes out(4096);
  std::size_t size = 0;
  if (log.load(out, size) != StoreStatus::kOk) return std::nullopt;
  out.resize(size);
  return out;
}

TEST(Crc32, CheckValueOfTheStandard) {
  const std::string_view text = "123456789";
  EXPECT_EQ(crc32(std::as_bytes(std::span(text))), 0xCBF43926U);
}

TEST(RecordSlots, BlankFlashHoldsNothing) {
  CutFlash flash(2, 2048, 8);
  RecordSlots log(flash);
  EXPECT_EQ(log.mount(), StoreStatus::kNothingStored);
  std::size_t size = 1;
  Bytes out(10);
  EXPECT_EQ(log.load(out, size), StoreStatus::kNothingStored);
  EXPECT_EQ(size, 0U);
}

TEST(RecordSlots, KeepsTheNewestOfManyRecordsOfAnySize) {
  for (const std::size_t unit : {1U, 2U, 8U, 16U, 32U}) {
    CutFlash flash(4, 1024, unit);
    std::mt19937 random(static_cast<unsigned>(unit));
    RecordSlots log(flash);
    log.mount();
    for (unsigned i = 0; i < 300; ++i) {
      const Bytes record = pattern(random() % 900, i);
      ASSERT_EQ(log.store(record), StoreStatus::kOk);
      ASSERT_EQ(newest(flash), record) << unit << ' ' << i;
    }
  }
}

TEST(RecordSlots, RefusesWhatDoesNotFit) {
  CutFlash flash(2, 2048, 8);
  RecordSlots log(flash);
  log.mount();
  const Bytes before = flash.bytes;
  EXPECT_EQ(log.store(Bytes(log.capacity() + 1)), StoreStatus::kTooLarge);
  EXPECT_EQ(flash.bytes, before);
  EXPECT_EQ(log.store(pattern(log.capacity(), 1)), StoreStatus::kOk);
  EXPECT_EQ(log.store(pattern(log.capacity(), 2)), StoreStatus::kOk);
  EXPECT_EQ(newest(flash), pattern(log.capacity(), 2));
}

// From flash with `earlier` records in it, cuts the next store at each of its steps in turn. Afterwards the
// old or the new record is there; and a store after the cut works.
void cut_every_step(std::size_t earlier, std::size_t size, CutFlash::Tear tear, bool unreadable) {
  CutFlash start(2, 1024, 8);
  {
    RecordSlots log(start);
    log.mount();
    for (unsigned i = 0; i < earlier; ++i) ASSERT_EQ(log.store(pattern(size, i)), StoreStatus::kOk);
  }
  start.steps = 0;
  const std::optional<Bytes> old = newest(start);
  const Bytes wanted = pattern(size, 1000);
  for (std::size_t step = 0;; ++step) {
    CutFlash flash = start;
    flash.cut_at = step;
    flash.tear = tear;
    flash.torn_unreadable = unreadable;
    RecordSlots log(flash);
    log.mount();
    const StoreStatus status = log.store(wanted);
    if (status == StoreStatus::kOk) {
      EXPECT_GT(step, size / 8) << "fewer steps than units to write";
      EXPECT_EQ(newest(flash), wanted);
      return;
    }
    flash.cut_at.reset();
    const std::optional<Bytes> found = newest(flash);
    ASSERT_TRUE(found == old || found == wanted) << "step " << step << " of " << earlier;
    for (unsigned again = 0; again < 3; ++again) {
      RecordSlots next(flash);
      next.mount();
      ASSERT_EQ(next.store(pattern(size, 2000 + again)), StoreStatus::kOk) << step;
      ASSERT_EQ(newest(flash), pattern(size, 2000 + again)) << step;
    }
  }
}

TEST(RecordSlots, PowerCutAtEveryStepLeavesTheOldOrTheNewRecord) {
  using Tear = CutFlash::Tear;
  for (std::size_t earlier = 0; earlier < 7; ++earlier) {
    for (const std::size_t size : {0U, 5U, 300U, 900U}) {
      for (const Tear tear : {Tear::nothing, Tear::garbage, Tear::half, Tear::all}) {
        for (const bool unreadable : {false, true}) cut_every_step(earlier, size, tear, unreadable);
        ASSERT_FALSE(HasFatalFailure());
      }
    }
  }
}

TEST(RecordSlots, TwoCutsInARowLoseNothing) {
  CutFlash start(2, 1024, 8);
  RecordSlots first(start);
  first.mount();
  ASSERT_EQ(first.store(pattern(500, 1)), StoreStatus::kOk);
  for (std::size_t one = 0; one < 70; ++one) {
    for (std::size_t two = 0; two < 70; two += 3) {
      CutFlash flash = start;
      flash.tear = CutFlash::Tear::garbage;
      for (const std::size_t step : {one, two}) {
        flash.cut_at = flash.steps + step;
        RecordSlots log(flash);
        log.mount();
        static_cast<void>(log.store(pattern(500, 2)));
        flash.cut_at.reset();
      }
      const std::optional<Bytes> found = newest(flash);
      ASSERT_TRUE(found == pattern(500, 1) || found == pattern(500, 2)) << one << ' ' << two;
    }
  }
}

TEST(RecordSlots, AFlippedBitIsNoticed) {
  CutFlash flash(2, 1024, 8);
  RecordSlots log(flash);
  log.mount();
  ASSERT_EQ(log.store(pattern(800, 1)), StoreStatus::kOk);
  ASSERT_EQ(log.store(pattern(800, 2)), StoreStatus::kOk);
  for (std::size_t at = 1024; at < 1024 + 24 + 800 + 4; ++at) {
    CutFlash damaged = flash;
    damaged.bytes[at] ^= std::byte{0x10};
    ASSERT_EQ(newest(damaged), pattern(800, 1)) << at;
  }
}

TEST(RecordSlots, WearIsCountedAndShared) {
  CutFlash flash(2, 1024, 8);
  RecordSlots log(flash);
  log.mount();
  for (unsigned i = 0; i < 1000; ++i) ASSERT_EQ(log.store(pattern(200, i)), StoreStatus::kOk);
  RecordSlots mounted(flash);
  mounted.mount();
  // 24 + 200 + 8 bytes each: four to a slot.
  EXPECT_EQ(flash.erased[0] + flash.erased[1], 250);
  EXPECT_EQ(mounted.erasures(0), static_cast<std::uint32_t>(flash.erased[0]));
  EXPECT_EQ(mounted.erasures(1), static_cast<std::uint32_t>(flash.erased[1]));
  EXPECT_LE(std::abs(flash.erased[0] - flash.erased[1]), 1);
  EXPECT_EQ(mounted.sequence(), 1000U);
}

// Two programs, each with a log of its own: the one that starts takes over what the other stored last.
TEST(RecordSlots, TakesOverTheNewerRecordOfAnotherLog) {
  std::mt19937 random(3);
  CutFlash pages[2] = {CutFlash(2, 1024, 8), CutFlash(2, 1024, 8)};
  std::optional<Bytes> last;
  for (unsigned i = 0; i < 400; ++i) {
    const std::size_t own = random() % 2;
    RecordSlots log(pages[own]);
    RecordSlots other(pages[own ^ 1U]);
    log.mount();
    other.mount();
    const Bytes untouched = pages[own ^ 1U].bytes;
    ASSERT_EQ(log.adopt(other), StoreStatus::kOk);
    ASSERT_EQ(pages[own ^ 1U].bytes, untouched);
    ASSERT_EQ(newest(pages[own]), last) << i;
    for (std::size_t stores = random() % 4; stores > 0; --stores) {
      last = pattern(random() % 900, static_cast<unsigned>(random()));
      ASSERT_EQ(log.store(*last), StoreStatus::kOk);
    }
  }
  RecordSlots log(pages[0]);
  log.mount();
  EXPECT_EQ(log.erasures(0), static_cast<std::uint32_t>(pages[0].erased[0])) << "of its own pages";
}

TEST(RecordSlots, PowerCutWhileTakingOverLosesNothing) {
  for (const bool unreadable : {false, true}) {
    for (const std::size_t before : {0U, 1U, 3U}) {
      CutFlash source(2, 1024, 8);
      CutFlash start(2, 1024, 8);
      RecordSlots other(source);
      other.mount();
      for (unsigned i = 0; i < 7; ++i) ASSERT_EQ(other.store(pattern(300, i)), StoreStatus::kOk);
      RecordSlots own(start);
      own.mount();
      for (unsigned i = 0; i < before; ++i) ASSERT_EQ(own.store(pattern(300, 50 + i)), StoreStatus::kOk);
      const std::optional<Bytes> old = newest(start);
      std::size_t step = 0;
      for (bool done = false; !done; ++step) {
        CutFlash flash = start;
        flash.cut_at = flash.steps + step;
        flash.tear = CutFlash::Tear::garbage;
        flash.torn_unreadable = unreadable;
        RecordSlots log(flash);
        log.mount();
        done = log.adopt(other) == StoreStatus::kOk;
        flash.cut_at.reset();
        const std::optional<Bytes> found = newest(flash);
        ASSERT_TRUE(found == pattern(300, 6) || (!done && found == old)) << step;
        RecordSlots again(flash);
        again.mount();
        ASSERT_EQ(again.adopt(other), StoreStatus::kOk) << step;
        ASSERT_EQ(newest(flash), pattern(300, 6)) << step;
      }
      EXPECT_GT(step, 300U / 8);
    }
  }
}

}  // namespace
}  // namespace slipstack
