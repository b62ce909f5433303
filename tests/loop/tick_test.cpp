// SPDX-License-Identifier: Apache-2.0
// The time of the tick: when it is late, when the one before was too long, and how long it refreshes the
// watchdog of a main loop that stands still; each on both sides of its bound, to the clock's count.
#include "firmware/control/tick.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "hal/host/board.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

constexpr std::uint32_t kPeriod = 1000;  // of a clock of 10 MHz

/// Writes after so long.
struct SlowIo {
  host::HostClock& clock;
  std::uint32_t takes = 0;
  std::uint32_t read() const { return 0; }
  void write(std::uint32_t) { clock.advance(takes); }
};

class TimedTick {
 public:
  TimedTick() {
    clock.rate_Hz = 10'000'000;
    clock.count = 0xFFFFFF00U;  // soon it wraps
    tick.set_period(kPeriod);
  }
  /// So long after the last one began; takes so long. Whether it was late.
  bool run(std::uint32_t after, std::uint32_t takes = 10) {
    clock.count = begin_ + after;
    begin_ = clock.count;
    io.takes = takes;
    const std::uint32_t before = tick.timing().overruns;
    tick.run();
    return tick.timing().overruns != before;
  }

  host::HostEncoder encoder;
  host::HostMotorCurrent motor;
  host::HostClock clock;
  host::HostWatchdog watchdog;
  SlowIo io{clock};
  Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog, SlowIo> tick{
      encoder, motor, clock, watchdog, io};

 private:
  std::uint32_t begin_ = 0xFFFFFF00U;
};

TEST(TickTime, IsLateFromMoreThanHalfAPeriodOn) {
  TimedTick one;
  EXPECT_FALSE(one.run(100000)) << "the first has none before it";
  EXPECT_FALSE(one.run(kPeriod));
  EXPECT_FALSE(one.run(kPeriod + kPeriod / 2));
  EXPECT_TRUE(one.run(kPeriod + kPeriod / 2 + 1));
  EXPECT_FALSE(one.run(kPeriod));
  EXPECT_FALSE(one.run(1)) << "early is not late";
  EXPECT_EQ(one.tick.timing().longest_period, kPeriod + kPeriod / 2 + 1);
  EXPECT_EQ(one.tick.timing().overruns, 1U);
}

TEST(TickTime, ATickLongerThanAPeriodIsToldByTheNextOne) {
  TimedTick one;
  one.run(kPeriod);
  EXPECT_FALSE(one.run(kPeriod, kPeriod)) << "as long as a period";
  EXPECT_FALSE(one.run(kPeriod, kPeriod + 1));
  EXPECT_TRUE(one.run(kPeriod + 1)) << "the one before was longer";
  EXPECT_FALSE(one.run(kPeriod));
  EXPECT_EQ(one.tick.timing().longest_duration, kPeriod + 1);
}

TEST(TickTime, ItsLongestTimesAreTheLargestOfAll) {
  test::Draw draw(1);
  TimedTick one;
  one.run(kPeriod);
  std::uint32_t longest_period = 0, longest_duration = 10, late = 0, lasted = 10;
  for (int i = 0; i < 2000; ++i) {
    const auto period = static_cast<std::uint32_t>(draw.below(std::size_t{2} * kPeriod));
    const auto takes = static_cast<std::uint32_t>(draw.below(kPeriod + kPeriod / 10));
    const bool should = period > kPeriod + kPeriod / 2 || lasted > kPeriod;
    ASSERT_EQ(one.run(period, takes), should) << period << ' ' << lasted;
    lasted = takes;
    longest_period = std::max(longest_period, period);
    longest_duration = std::max(longest_duration, takes);
    late += should ? 1 : 0;
    ASSERT_EQ(one.tick.timing().longest_period, longest_period);
    ASSERT_EQ(one.tick.timing().longest_duration, longest_duration);
    ASSERT_EQ(one.tick.timing().overruns, late);
  }
}

TEST(TickTime, WithoutAPeriodNothingIsLate) {
  TimedTick one;
  one.tick.set_period(0);
  one.run(kPeriod);
  EXPECT_FALSE(one.run(4'000'000'000U, 3'000'000'000U));
  EXPECT_FALSE(one.run(4'000'000'000U));
  EXPECT_EQ(one.watchdog.refreshed, 3U);
}

// Half a second after its last pass the main loop counts as standing still.
TEST(TickTime, TheWatchdogIsRefreshedForHalfASecondWithoutTheMainLoop) {
  TimedTick one;
  constexpr std::uint32_t kHalfASecond = 5'000'000;
  one.tick.main_loop_ran();
  one.run(kHalfASecond);
  EXPECT_EQ(one.watchdog.refreshed, 1U);
  one.run(1);
  EXPECT_EQ(one.watchdog.refreshed, 1U) << "no longer";
  one.run(kPeriod);
  EXPECT_EQ(one.watchdog.refreshed, 1U);
  one.tick.main_loop_ran();
  one.run(kPeriod);
  EXPECT_EQ(one.watchdog.refreshed, 2U);
}

}  // namespace
}  // namespace slipstack
