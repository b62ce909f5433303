// SPDX-License-Identifier: Apache-2.0
// How warm an axis is at the start: what nobody knows is taken for the least friction, what the master knows
// is taken over.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr float kTimeConstant_s = 100.0F;
constexpr float kObserved_s = 1e4F;  // the change is that of infinite time, to 2^-24

// A drive whose friction changes by this share of itself, after a start and two seconds.
struct Started {
  Started(float change, std::optional<std::uint32_t> run_before_s) {
    bench.configure();
    // 2111h: enabled, change, time constant, observed time.
    EXPECT_EQ(bench.write(0x2111, 1, 1, 1), 0U);
    EXPECT_EQ(bench.write_real(0x2111, 2, change), 0U);
    EXPECT_EQ(bench.write_real(0x2111, 3, kTimeConstant_s), 0U);
    EXPECT_EQ(bench.write_real(0x2111, 4, kObserved_s), 0U);
    if (run_before_s) {
      EXPECT_EQ(bench.write(0x2404, 1, *run_before_s, 4), 0U);
    }
    EXPECT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0U);
    bench.power_on();
    bench.begin();
    bench.run_ms(2000);
    // A move that leaves the hysteresis at its level.
    bench.enable(1);
    EXPECT_EQ(bench.write(0x6081, 0, 20000, 4), 0U);
    EXPECT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(bench.read_signed(0x6064, 0) + 20000), 4),
              0U);
    EXPECT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
    bench.run_ms(500);
  }
  // Share of the change that has come, as the model has it: force of the drift over that of the hysteresis.
  double share(float change) {
    return static_cast<double>(bench.read_real(0x2201, 18) / bench.read_real(0x2201, 2) / change);
  }
  Bench bench;
};

double expected(double time_s) {
  return 1.0 - std::exp(-time_s / static_cast<double>(kTimeConstant_s));
}

TEST(DriftStart, WhatIsNotKnownIsTakenForTheLeastFriction) {
  Started falls(-0.3F, std::nullopt);
  EXPECT_NEAR(falls.share(-0.3F), 1.0, 1e-4) << "warm: the friction of a cold axis is at least that";
  EXPECT_GT(falls.bench.read_real(0x2404, 2), 1e8F);
  Started rises(0.3F, std::nullopt);
  EXPECT_NEAR(rises.share(0.3F), expected(2.5), 2e-3) << "cold";
  EXPECT_NEAR(rises.bench.read_real(0x2404, 2), 2.5F, 0.1F);
}

TEST(DriftStart, WhatIsKnownGoesOn) {
  for (const std::uint32_t before_s : {0U, 60U, 300U}) {
    for (const float change : {-0.3F, 0.3F}) {
      Started axis(change, before_s);
      EXPECT_NEAR(axis.share(change), expected(before_s + 2.5), 2e-3) << before_s << ' ' << change;
      EXPECT_NEAR(axis.bench.read_real(0x2404, 2), static_cast<float>(before_s) + 2.5F, 0.1F);
    }
  }
}

// What a master reads before a short stop of the power and writes after it is the state of before.
TEST(DriftStart, TheMasterCarriesItOverAPowerCut) {
  Started axis(-0.3F, 40U);
  const float before_s = axis.bench.read_real(0x2404, 2);
  Bench& bench = axis.bench;
  bench.power_on();
  bench.begin();
  bench.run_ms(10);
  ASSERT_EQ(bench.write(0x2404, 1, static_cast<std::uint32_t>(before_s), 4), 0U);
  ASSERT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
  bench.run_ms(5);
  EXPECT_NEAR(bench.read_real(0x2404, 2), before_s, 1.0F);
}

}  // namespace
}  // namespace slipstack::can
