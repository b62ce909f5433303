// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/clock_tree.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::Journal;
using test::SimWord;

TEST(ClockPlan, BothSourcesGive170MHzWithinTheLimits) {
  for (const ClockPlan& plan : {kHsePlan, kHsiPlan}) {
    EXPECT_TRUE(keeps_limits(plan));
    EXPECT_EQ(plan.pll_input_Hz(), 4'000'000U);
    EXPECT_EQ(plan.vco_Hz(), 340'000'000U);  // 96 ... 344 MHz
    EXPECT_EQ(plan.core_Hz(), 170'000'000U);
    EXPECT_EQ(plan.flash_wait_states, 4U);
  }
}

TEST(ClockPlan, EveryLimitIsKept) {
  const auto with = [](auto change) {
    ClockPlan plan = kHsePlan;
    change(plan);
    return keeps_limits(plan);
  };
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_multiply = 87; }));  // VCO 348 MHz
  EXPECT_TRUE(with([](ClockPlan& p) { p.pll_multiply = 24; }));   // 96 MHz
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_multiply = 23; }));  // 92 MHz
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_multiply = 86; }));  // core 172 MHz
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_divide_in = 7; }));  // not a divisor
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_divide_in = 0; }));
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_divide_in = 1, p.pll_multiply = 14; }));    // PLL input 24 MHz
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_divide_in = 12, p.pll_multiply = 127; }));  // PLL input 2 MHz
  EXPECT_FALSE(with([](ClockPlan& p) { p.pll_divide_out = 3; }));
  EXPECT_FALSE(with([](ClockPlan& p) { p.flash_wait_states = 3; }));
}

// RM0440, number of wait states according to CPU clock, range 1 boost.
TEST(ClockPlan, WaitStatesFollowTheManualsTable) {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> table = {
      {1'000'000, 0},   {34'000'000, 0},  {34'000'001, 1},  {68'000'000, 1},  {68'000'001, 2},
      {102'000'000, 2}, {102'000'001, 3}, {136'000'000, 3}, {136'000'001, 4}, {170'000'000, 4}};
  for (const auto& [clock, states] : table) EXPECT_EQ(flash_wait_states_boost(clock), states) << clock;
}

// Clocks that come up after a few reads, unless they are broken.
struct SimClocks {
  Rcc<SimWord> rcc;
  Pwr<SimWord> pwr;
  Flash<SimWord> flash;
  Journal journal;
  bool crystal_works = true;
  bool pll_works = true;
  bool switch_works = true;
  bool flash_answers = true;
  std::uint32_t waited_us = 0;
  std::uint32_t reads = 0;

  SimClocks() {
    pwr.cr5.value = 0x100;  // normal mode after reset
    rcc.cr.value = 0x500;   // HSI16 on and ready
    rcc.cfgr.value = 0x5;   // and in use
    rcc.cr.on_read = [this](std::uint32_t value) {
      ++reads;
      value &= ~(kRCC_CR_HSERDY.mask | kRCC_CR_PLLRDY.mask);
      if (crystal_works && (value & kRCC_CR_HSEON.mask) != 0 && reads > 5) value |= kRCC_CR_HSERDY.mask;
      if (pll_works && (value & kRCC_CR_PLLON.mask) != 0) value |= kRCC_CR_PLLRDY.mask;
      return value;
    };
    rcc.cfgr.on_write = [this](SimWord& self, std::uint32_t written) {
      self.value = (written & ~kRCC_CFGR_SWS.mask) | (self.value & kRCC_CFGR_SWS.mask);
      if (switch_works) self.value = (self.value & ~kRCC_CFGR_SWS.mask) | kRCC_CFGR_SWS.place(written & 3U);
    };
    flash.acr.on_read = [this](std::uint32_t value) { return flash_answers ? value : value & ~0xFU; };
    journal.watch(rcc.cr, "CR");
    journal.watch(rcc.cfgr, "CFGR");
    journal.watch(rcc.pllcfgr, "PLLCFGR");
    journal.watch(pwr.cr5, "CR5");
    journal.watch(flash.acr, "ACR");
  }

  ClockStart start() {
    return start_clock_tree(rcc, pwr, flash, [this](std::uint32_t us) { waited_us += us; });
  }
};

TEST(ClockTree, StartsFromTheCrystal) {
  SimClocks clocks;
  const ClockStart start = clocks.start();
  EXPECT_EQ(start.fault, ClockFault::kNone);
  EXPECT_EQ(start.source, ClockSource::kHse);
  // What the registers hold at the end, field by field as in the manual.
  const std::uint32_t pll = clocks.rcc.pllcfgr.value;
  EXPECT_EQ(pll & 3U, 3U);                           // HSE
  EXPECT_EQ((pll >> 4U) & 0xFU, 5U);                 // M = 6
  EXPECT_EQ((pll >> 8U) & 0x7FU, 85U);               // N
  EXPECT_EQ((pll >> 25U) & 3U, 0U);                  // R = 2
  EXPECT_NE(pll & (1U << 24U), 0U);                  // R output on
  EXPECT_EQ(clocks.rcc.cfgr.value & 0x3FFFU, 0xFU);  // PLL in use, no prescalers left
  EXPECT_EQ(clocks.flash.acr.value & 0xFU, 4U);
  EXPECT_EQ(clocks.flash.acr.value & 0x700U, 0x700U);  // prefetch and caches
  EXPECT_EQ(clocks.pwr.cr5.value & 0x100U, 0U);        // boost
  EXPECT_NE(clocks.rcc.cr.value & (1U << 19U), 0U);    // clock security
}

TEST(ClockTree, KeepsTheManualsOrder) {
  SimClocks clocks;
  ASSERT_EQ(clocks.start().fault, ClockFault::kNone);
  const Journal& journal = clocks.journal;
  const int boost = journal.first("CR5", 0x100, 0);
  const int latency = journal.first("ACR", 0xF, 4);
  const int pll_set = journal.first("PLLCFGR", 0x7F00, 85U << 8U);
  const int pll_on = journal.first("CR", kRCC_CR_PLLON.mask, kRCC_CR_PLLON.mask);
  const int half = journal.first("CFGR", 0xF0, 0x80);
  const int in_use = journal.first("CFGR", 3, 3);
  const int full = journal.first("CFGR", 0xF3, 0x03);
  EXPECT_LT(-1, boost);
  EXPECT_LT(boost, latency);
  EXPECT_LT(latency, in_use);
  EXPECT_LT(pll_set, pll_on);
  EXPECT_LT(pll_on, in_use);
  EXPECT_LT(half, in_use);
  EXPECT_LT(in_use, full);
  EXPECT_GE(clocks.waited_us, 1U);
}

TEST(ClockTree, GoesOnWithoutTheCrystal) {
  SimClocks clocks;
  clocks.crystal_works = false;
  const ClockStart start = clocks.start();
  EXPECT_EQ(start.fault, ClockFault::kNone);
  EXPECT_EQ(start.source, ClockSource::kHsi);
  EXPECT_EQ(clocks.rcc.pllcfgr.value & 3U, 2U);
  EXPECT_EQ((clocks.rcc.pllcfgr.value >> 4U) & 0xFU, 3U);  // M = 4
  EXPECT_EQ(clocks.rcc.cr.value & kRCC_CR_HSEON.mask, 0U);
  EXPECT_EQ(clocks.rcc.cr.value & kRCC_CR_CSSON.mask, 0U);  // would raise the NMI at once
}

TEST(ClockTree, SaysWhatDidNotAnswer) {
  SimClocks no_pll;
  no_pll.pll_works = false;
  EXPECT_EQ(no_pll.start().fault, ClockFault::kPllNotLocked);
  EXPECT_EQ(no_pll.rcc.cfgr.value & 3U, 1U) << "the core must stay on HSI16";

  SimClocks no_switch;
  no_switch.switch_works = false;
  EXPECT_EQ(no_switch.start().fault, ClockFault::kNotSwitched);

  SimClocks slow_flash;
  slow_flash.flash_answers = false;
  EXPECT_EQ(slow_flash.start().fault, ClockFault::kFlashLatency);
  EXPECT_EQ(slow_flash.rcc.cfgr.value & 3U, 1U) << "170 MHz without wait states reads garbage";
}

TEST(ResetCauseOf, TellsTheWatchdogFromThePin) {
  const std::uint32_t pin = 1U << 26U;
  const std::vector<std::pair<std::uint32_t, ResetCause>> table = {
      {pin, ResetCause::kPin},
      {pin | 1U << 29U, ResetCause::kWatchdog},
      {pin | 1U << 30U, ResetCause::kWatchdog},
      {pin | 1U << 28U, ResetCause::kSoftware},
      {pin | 1U << 27U, ResetCause::kPower},
      {pin | 1U << 31U, ResetCause::kOther},
      {pin | 1U << 28U | 1U << 29U, ResetCause::kWatchdog}};
  for (const auto& [flags, cause] : table) {
    Rcc<SimWord> rcc;
    rcc.csr.value = flags;
    EXPECT_EQ(take_reset_cause(rcc), cause) << std::hex << flags;
    EXPECT_NE(rcc.csr.value & (1U << 23U), 0U) << "not cleared for the next start";
  }
}

}  // namespace
}  // namespace slipstack::stm32g474
