// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/can_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace slipstack::stm32g474 {
namespace {

struct Case {
  std::uint32_t clock_Hz;
  std::uint32_t bit_rate;
  CanBitTiming timing;
};

template <std::uint32_t kClock_Hz, std::uint32_t kBitRate>
constexpr Case planned() {
  constexpr CanBitTiming kPlanned = plan_can_timing(kClock_Hz, kBitRate);
  return {kClock_Hz, kBitRate, kPlanned};
}

// The rates of CiA 301 at the crystal's clock, at the bus clock, and at clocks of other boards.
constexpr std::array kCases = {
    planned<24'000'000, 1'000'000>(), planned<24'000'000, 800'000>(),   planned<24'000'000, 500'000>(),
    planned<24'000'000, 250'000>(),   planned<24'000'000, 125'000>(),   planned<24'000'000, 50'000>(),
    planned<24'000'000, 20'000>(),    planned<24'000'000, 10'000>(),    planned<170'000'000, 1'000'000>(),
    planned<170'000'000, 500'000>(),  planned<170'000'000, 250'000>(),  planned<170'000'000, 125'000>(),
    planned<80'000'000, 1'000'000>(), planned<16'000'000, 1'000'000>(), planned<8'000'000, 1'000'000>()};

TEST(CanTiming, HasExactRatesAndSamplesWhereCiaAsks) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(testing::Message() << c.clock_Hz << " Hz, " << c.bit_rate << " bit/s");
    ASSERT_TRUE(c.timing.valid());
    EXPECT_EQ(c.timing.prescaler * c.timing.quanta() * c.bit_rate, c.clock_Hz);
    EXPECT_GE(c.timing.sample_point_e4(), 7500U);
    EXPECT_LE(c.timing.sample_point_e4(), 8750U);
    EXPECT_LE(c.timing.jump_width, std::min(c.timing.segment_1, c.timing.segment_2));
    // FDCAN_NBTP holds each less one.
    EXPECT_LE(c.timing.prescaler, 512U);
    EXPECT_LE(c.timing.segment_1, 256U);
    EXPECT_GE(c.timing.segment_1, 2U);
    EXPECT_LE(c.timing.segment_2, 128U);
    EXPECT_GE(c.timing.segment_2, 2U);
    EXPECT_LE(c.timing.jump_width, 128U);
  }
}

// Oracle: every setting of the register there is.
TEST(CanTiming, NoSettingSamplesNearerTo875) {
  for (const Case& c : kCases) {
    std::uint32_t nearest = 0;
    for (std::uint32_t prescaler = 1; prescaler <= 512; ++prescaler) {
      for (std::uint32_t segment_1 = 2; segment_1 <= 256; ++segment_1) {
        for (std::uint32_t segment_2 = 2; segment_2 <= 128; ++segment_2) {
          const std::uint32_t quanta = 1 + segment_1 + segment_2;
          if (quanta < 8 || std::uint64_t{prescaler} * quanta * c.bit_rate != c.clock_Hz) continue;
          if (1000 * (1 + segment_1) > 875 * quanta) continue;
          nearest = std::max(nearest, 10'000 * (1 + segment_1) / quanta);
        }
      }
    }
    EXPECT_EQ(c.timing.sample_point_e4(), nearest) << c.clock_Hz << " " << c.bit_rate;
  }
}

TEST(CanTiming, IsByHandAtTheCrystal) {
  constexpr CanBitTiming kOneMbit = plan_can_timing(24'000'000, 1'000'000);
  EXPECT_EQ(kOneMbit.prescaler, 1U);
  EXPECT_EQ(kOneMbit.segment_1, 20U);
  EXPECT_EQ(kOneMbit.segment_2, 3U);
  EXPECT_EQ(kOneMbit.jump_width, 3U);
  EXPECT_EQ(kOneMbit.sample_point_e4(), 8750U);
  // 3 / (20 * 24) and 3 / (2 * (13 * 24 - 3)).
  EXPECT_EQ(kOneMbit.clock_tolerance_ppm(), 4854U);
  EXPECT_EQ(kOneMbit.bit_rate(24'000'000), 1'000'000U);
}

TEST(CanTiming, RefusesWhatTheClockDoesNotGive) {
  static_assert(!plan_can_timing(24'000'000, 700'000).valid());   // no divisor
  static_assert(!plan_can_timing(4'000'000, 1'000'000).valid());  // 4 quanta
  static_assert(!plan_can_timing(24'000'000, 24'000'000).valid());
  static_assert(!plan_can_timing(24'000'000, 1U << 23U).valid());  // 512 times this is 2^32
  static_assert(!plan_can_timing(24'000'000, 0).valid());
  static_assert(!CanBitTiming{}.valid());
}

}  // namespace
}  // namespace slipstack::stm32g474
