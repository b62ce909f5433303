// SPDX-License-Identifier: Apache-2.0
// When the lock on SYNC is won, kept and lost, on both sides of each bound; and that what it predicts comes
// about.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/control/streams/sync_clock.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

/// A clock, and a main loop after each tick.
class ClockOnSync {
 public:
  static constexpr std::uint32_t kPeriod = 20;
  ClockOnSync() { clock.set_period(static_cast<float>(kPeriod), 1e-4F); }

  /// One period on, SYNC at its end; `late` by so many ticks of it.
  void period(bool sync = true, std::uint32_t late = 0) {
    for (std::uint32_t i = 0; i < kPeriod; ++i) {
      if (sync && late > 0 && i == late) clock.sync(tick_);
      clock.follow(++tick_);
    }
    if (sync && late == 0) clock.sync(tick_);
  }
  void periods(int count, bool sync = true) {
    for (int i = 0; i < count; ++i) period(sync);
  }
  std::uint32_t tick() const { return tick_; }

  SyncClock clock;

 private:
  std::uint32_t tick_ = 12345;
};

// One SYNC in four may be missing or out of place for ever, and one in two not: a good one makes up for half
// of a bad one.
TEST(SyncLock, IsKeptWithEveryFourthSyncMissingOrOutOfPlace) {
  for (const bool missing : {false, true}) {
    ClockOnSync kept;
    kept.periods(60);
    ASSERT_TRUE(kept.clock.locked());
    for (int i = 0; i < 4000; ++i) {
      kept.period(i % 4 != 3 || !missing, i % 4 == 3 && !missing ? 11 : 0);
      ASSERT_TRUE(kept.clock.locked()) << i << ' ' << missing;
    }
  }
  // SYNCs half a period out of place, every other one.
  ClockOnSync lost;
  lost.periods(60);
  int pairs = 0;
  for (; lost.clock.locked() && pairs < 1000; ++pairs) {
    lost.period();
    lost.period(true, 11);
  }
  EXPECT_GT(pairs, 10);
  EXPECT_LT(pairs, 40);
}

// However long it has been right, the lock is lost after so many SYNCs out of place in a row: 32 good ones
// are kept in mind, each bad one takes two of them. Fewer do no harm.
TEST(SyncLock, IsLostAfterSixteenSyncsOutOfPlace) {
  const auto bad_until_lost = [](int good) {
    ClockOnSync one;
    one.periods(good);
    EXPECT_TRUE(one.clock.locked());
    int bad = 0;
    // Each half a period from where the loop is, wherever it has gone.
    while (one.clock.locked() && bad < 1000) {
      std::uint32_t tick = one.tick() + static_cast<std::uint32_t>(++bad) * ClockOnSync::kPeriod;
      while (std::abs(static_cast<double>(one.clock.at(tick).fraction) * 0x1p-32 - 0.5) > 0.051) ++tick;
      one.clock.sync(tick);
    }
    return bad;
  };
  // The first SYNC has none before it.
  EXPECT_EQ(bad_until_lost(1000), 16);
  EXPECT_EQ(bad_until_lost(33), 16);
  EXPECT_EQ(bad_until_lost(21), 10);
  EXPECT_EQ(bad_until_lost(11), 5);
}

// A silence: the phase drifts by the lock range, 3 % of a period after 64 of them; then it begins anew.
TEST(SyncLock, SurvivesASilenceOf64Periods) {
  for (const int silent : {1, 10, 63, 64, 65, 200}) {
    ClockOnSync one;
    one.periods(60);
    one.periods(silent - 1, false);
    one.period();
    EXPECT_EQ(one.clock.locked(), silent <= 64) << silent;
    EXPECT_LT(std::abs(one.clock.deviation()), 1e-8F);
    one.periods(8);
    EXPECT_TRUE(one.clock.locked()) << silent << ": and is won again";
  }
}

// Another period is another clock, the same one is not; beyond what can be told from ticks it is the nearest
// that can.
TEST(SyncLock, BeginsAnewWithAnotherPeriod) {
  ClockOnSync one;
  one.periods(20);
  one.clock.set_period(static_cast<float>(ClockOnSync::kPeriod), 1e-4F);
  EXPECT_TRUE(one.clock.locked());
  one.clock.set_period(21.0F, 1e-4F);
  EXPECT_FALSE(one.clock.locked());
  EXPECT_EQ(one.clock.period_ticks(), 21.0F);
  one.clock.set_period(0.5F, 1e-4F);
  EXPECT_EQ(one.clock.period_ticks(), 2.0F);
  one.clock.set_period(1e6F, 1e-4F);
  EXPECT_EQ(one.clock.period_ticks(), 1000.0F);
}

// What a SYNC makes of the rate comes about over a period, evenly: the rate so many ticks on, and the ticks
// to a phase, are told beforehand.
TEST(SyncLock, WhatIsToldOfTheRateComesAbout) {
  test::Draw draw(3);
  for (const std::uint32_t period : {10U, 40U, 100U, 1000U}) {
    SyncClock clock;
    clock.set_period(static_cast<float>(period), 1e-4F);
    const auto ticks = static_cast<double>(period);
    std::uint32_t tick = 77;
    double largest_change = 0.0;
    for (int n = 0; n < 200; ++n) {
      // A clock that is fast by 300 ppm, and SYNCs that come out of place.
      const auto off = static_cast<std::uint32_t>(draw.below(period / 4 + 1));
      for (std::uint32_t i = 0; i < period - period / 8 + off; ++i) clock.follow(++tick);
      clock.sync(tick);
      const double begin =
          static_cast<double>(clock.at(tick).period) + static_cast<double>(clock.at(tick).fraction) * 0x1p-32;
      const double asked = draw.uniform(0.1, 4.0);
      const auto told = static_cast<double>(clock.ticks_until(static_cast<float>(asked)));
      const auto later = static_cast<std::uint32_t>(draw.below(std::size_t{2} * period));
      const float rate_told = clock.rate_in(static_cast<float>(later));
      const float now = clock.rate(), wanted = clock.wanted_rate();
      largest_change = std::max(largest_change, std::abs(static_cast<double>((wanted - now) / now)));
      SyncClock ahead;  // the same clock, without another SYNC
      std::memcpy(static_cast<void*>(&ahead), &clock, sizeof clock);
      std::uint32_t at = tick;
      double phase = begin;
      float rate_then = now;
      for (std::uint32_t i = 1; i <= 5 * period; ++i) {
        const double last = phase;
        ahead.follow(++at);
        const SyncClock::Phase is = ahead.at(at);
        phase = static_cast<double>(is.period) + static_cast<double>(is.fraction) * 0x1p-32;
        if (i == later) rate_then = ahead.rate();
        if (last < begin + asked && phase >= begin + asked) {
          const double crossed = i - 1 + (begin + asked - last) / (phase - last);
          EXPECT_NEAR(crossed, told, 2e-5 * ticks + 1e-6 * told + ticks * ticks * ticks * 0x1p-32)
              << period << ' ' << n;
        }
      }
      // To two ticks of the change, and a bit in each tick of it.
      EXPECT_NEAR(rate_told, rate_then,
                  2.0F * std::abs(wanted - now) / static_cast<float>(period) +
                      static_cast<float>(period) * 0x1p-32F + 1e-8F)
          << period << ' ' << n;
      EXPECT_EQ(ahead.rate(), wanted) << "and then it stays";
    }
    EXPECT_GT(largest_change, 2e-6) << period;
  }
}

}  // namespace
}  // namespace slipstack
