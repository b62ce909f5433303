// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/timing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

TEST(TickTimer, DividesTheCoreClock) {
  for (const auto& [rate_Hz, limit] :
       {std::pair{5'000U, 33'999U}, {10'000U, 16'999U}, {20'000U, 8'499U}, {40'000U, 4'249U}}) {
    Timer<SimWord> timer;
    TickTimer tick(timer);
    ASSERT_TRUE(tick.start(rate_Hz));
    EXPECT_EQ(timer.arr.value, limit);
    EXPECT_EQ(timer.psc.value, 0U);
    EXPECT_EQ(timer.dier.value, 1U);
    EXPECT_EQ(timer.cr1.value, 1U);
    EXPECT_LE(timer.arr.value, 0xFFFFU) << "TIM6 has 16 bits";
  }
}

TEST(TickTimer, RefusesRatesItCannotKeep) {
  Timer<SimWord> timer;
  TickTimer tick(timer);
  for (const std::uint32_t rate_Hz : {0U, 1U, 4'999U, 40'001U, 4'000'000'000U})
    EXPECT_FALSE(tick.start(rate_Hz)) << rate_Hz;
  EXPECT_EQ(timer.cr1.writes, 0U);
  // Every rate it takes is kept within 0.01 %.
  int refused = 0;
  for (std::uint32_t rate_Hz = 5'000; rate_Hz <= 40'000; ++rate_Hz) {
    if (!tick.start(rate_Hz)) {
      ++refused;
      continue;
    }
    const double real_Hz = 170e6 / (timer.arr.value + 1.0);
    ASSERT_NEAR(real_Hz / rate_Hz, 1.0, 1.01e-4) << rate_Hz;
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 5'000);
}

TEST(TickTimer, MeasuresLatencyAndOverruns) {
  Timer<SimWord> timer;
  test::clear_by_zero(timer.sr);
  TickTimer tick(timer);
  ASSERT_TRUE(tick.start(10'000));
  const auto run = [&](std::uint32_t latency, std::uint32_t end, bool again) {
    timer.sr.value = 1;
    timer.cnt.value = latency;
    tick.begin();
    EXPECT_EQ(timer.sr.value, 0U) << "the interrupt would come back at once";
    timer.cnt.value = end;
    if (again) timer.sr.value = 1;
    tick.end();
  };
  run(40, 1500, false);
  run(35, 1400, false);
  run(52, 2600, false);
  EXPECT_EQ(tick.timing().ticks, 3U);
  EXPECT_EQ(tick.timing().latency_min, 35U);
  EXPECT_EQ(tick.timing().latency_max, 52U);
  EXPECT_EQ(tick.timing().duration_max, 2600U);
  EXPECT_EQ(tick.timing().overruns, 0U);
  run(40, 100, true);
  EXPECT_EQ(tick.timing().overruns, 1U);
  EXPECT_EQ(tick.timing().duration_max, 17'000U) << "a period or more";
  EXPECT_EQ(timer.sr.value, 1U) << "the next tick must not be lost";
  tick.reset_extremes();
  run(44, 1000, false);
  EXPECT_EQ(tick.timing().latency_min, 44U);
  EXPECT_EQ(tick.timing().latency_max, 44U);
  EXPECT_EQ(tick.timing().duration_max, 1000U);
  EXPECT_EQ(tick.timing().ticks, 5U);
}

TEST(CycleClock, CountsCyclesFromItsStart) {
  Dwt<SimWord> dwt;
  dwt.cyccnt.value = 99;
  CycleClock clock(dwt);
  clock.start();
  EXPECT_EQ(dwt.ctrl.value & 1U, 1U);
  EXPECT_EQ(clock.now(), 0U);
  dwt.cyccnt.value = 170'000'000;
  EXPECT_EQ(clock.now(), clock.ticks_per_second());
}

// Oracle: every setting there is, searched for the shortest time-out that is long enough.
TEST(WatchdogPlan, IsTheFinestThatIsLongEnough) {
  for (const double timeout_us : {125.0, 126.0, 1e3, 2e4, 1e5, 5e5, 512e3, 513e3, 1e6, 7.777e6, 32.7e6}) {
    const WatchdogPlan plan = plan_watchdog(static_cast<std::uint32_t>(timeout_us));
    ASSERT_TRUE(plan.valid) << timeout_us;
    double finest_us = 1e12;
    for (int code = 0; code <= 6; ++code) {
      for (int reload = 0; reload <= 4095; ++reload) {
        const double us = 4.0 * std::pow(2.0, code) * (reload + 1) / 0.032;
        if (us >= timeout_us) finest_us = std::min(finest_us, us);
      }
    }
    EXPECT_EQ((4.0 * std::pow(2.0, plan.prescaler_code) * (plan.reload + 1)) / 0.032, finest_us)
        << timeout_us;
    EXPECT_LE(plan.reload, 4095U);
    EXPECT_LE(plan.prescaler_code, 6U);
  }
}

TEST(WatchdogPlan, KnowsItsSpreadAndItsBounds) {
  constexpr WatchdogPlan kWatchdogPlan = plan_watchdog(20'000);
  EXPECT_EQ(kWatchdogPlan.prescaler_code, 0U);
  EXPECT_EQ(kWatchdogPlan.reload, 159U);
  EXPECT_EQ(kWatchdogPlan.nominal_us(), 20'000U);
  EXPECT_EQ(kWatchdogPlan.shortest_us(), 18'823U);  // 34 kHz
  EXPECT_EQ(kWatchdogPlan.longest_us(), 21'694U);   // 29.5 kHz
  EXPECT_FALSE(plan_watchdog(0).valid);
  EXPECT_TRUE(plan_watchdog(32'768'000).valid);
  EXPECT_FALSE(plan_watchdog(32'768'001).valid);
}

struct SimWatchdog {
  Iwdg<SimWord> registers;
  bool running = false;
  bool open = false;
  bool takes_settings = true;
  std::uint32_t refreshes = 0;
  std::uint32_t updating = 0;

  SimWatchdog() {
    registers.rlr.value = 0xFFF;
    registers.kr.on_write = [this](SimWord&, std::uint32_t key) {
      open = key == 0x5555;
      if (key == 0xCCCC) running = true;
      if (key == 0xAAAA) ++refreshes;
    };
    for (SimWord* setting : {&registers.pr, &registers.rlr}) {
      setting->on_write = [this](SimWord& self, std::uint32_t written) {
        if (!open) return;
        self.value = written;
        updating = 6;
      };
    }
    registers.sr.on_read = [this](std::uint32_t) {
      if (updating == 0) return 0U;
      if (takes_settings) --updating;
      return 3U;
    };
  }
};

TEST(IndependentWatchdog, StartsSetUpAndRefreshed) {
  SimWatchdog sim;
  IndependentWatchdog watchdog(sim.registers);
  ASSERT_TRUE(watchdog.start(plan_watchdog(1'000'000)));
  EXPECT_TRUE(sim.running);
  EXPECT_FALSE(sim.open) << "a stray write must not change it";
  EXPECT_EQ(sim.registers.pr.value, 1U);
  EXPECT_EQ(sim.registers.rlr.value, 3999U);
  EXPECT_EQ(sim.refreshes, 1U);
  watchdog.refresh();
  EXPECT_EQ(sim.refreshes, 2U);
  EXPECT_FALSE(watchdog.caused_last_reset());
  watchdog.note_last_reset(true);
  EXPECT_TRUE(watchdog.caused_last_reset());
}

TEST(IndependentWatchdog, SaysWhenItDoesNotTakeItsSettings) {
  SimWatchdog sim;
  sim.takes_settings = false;
  IndependentWatchdog watchdog(sim.registers);
  EXPECT_FALSE(watchdog.start(plan_watchdog(20'000)));
  SimWatchdog untouched;
  EXPECT_FALSE(IndependentWatchdog(untouched.registers).start(plan_watchdog(0)));
  EXPECT_FALSE(untouched.running);
}

}  // namespace
}  // namespace slipstack::stm32g474
