// SPDX-License-Identifier: Apache-2.0
// NMT reset and restored defaults: what runs is what the objects read.
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kSaveWord = 0x65766173;  // "save"
constexpr std::uint32_t kLoadWord = 0x64616F6C;  // "load"

// By controlword towards operation enabled, without success expected.
std::uint32_t try_to_enable(Bench& bench) {
  bench.write(0x6060, 0, 1, 1);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    bench.write(0x6040, 0, word, 2);
    bench.run_ms(2);
  }
  return bench.read(0x6041, 0) & 0x6F;
}

// A move of 150 mm under way at 0.2 m/s or more.
void start_moving(Bench& bench) {
  bench.enable(1);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home + 150000), 4), 0U);
  ASSERT_EQ(bench.write(0x6081, 0, 300000, 4), 0U);
  ASSERT_EQ(bench.write(0x6083, 0, 5000000, 4), 0U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  bench.run_ms(250);
  ASSERT_GT(bench.loop->plant.velocity_mps(), 0.2);
}

TEST(Reset, WithDefaultsRestoredNothingRuns) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x1010, 1, kSaveWord, 4), 0U);
  ASSERT_EQ(bench.write(0x1011, 1, kLoadWord, 4), 0U);
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x2140, 2), 0U) << "no model is active";
  EXPECT_EQ(bench.read(0x2140, 4), static_cast<std::uint32_t>(ParameterStatus::kNoMass));
  EXPECT_EQ(try_to_enable(bench) & 0x4F, 0x40U);
  EXPECT_FALSE(bench.loop->motor.enabled);
  EXPECT_EQ(bench.read(0x603F, 0), 0U) << "no parameters are no fault";
}

// What is staged but not stored is gone with the reset, and what ran with it.
TEST(Reset, WhatWasAppliedButNotStoredRunsNoLonger) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x1010, 1, kSaveWord, 4), 0U);
  const std::uint32_t stored = bench.read(0x2140, 2);
  ASSERT_EQ(bench.write_real(0x2100, 2, 50.0F), 0U);
  ASSERT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U);
  bench.run_ms(2);
  ASSERT_NE(bench.read(0x2140, 2), stored);
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x2140, 1), stored);
  EXPECT_EQ(bench.read(0x2140, 2), stored);
  EXPECT_EQ(try_to_enable(bench), 0x27U);
}

// Resolution and tick are fixed from the first apply on; a reset is a start.
TEST(Reset, AnotherResolutionComesIntoForce) {
  Bench bench;
  bench.configure();
  const float resolution_m = bench.read_real(0x2000, 1);
  ASSERT_EQ(bench.write_real(0x2000, 1, 2.0F * resolution_m), 0U);
  EXPECT_NE(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0U) << "fixed while it runs";
  ASSERT_EQ(bench.write(0x1010, 1, kSaveWord, 4), 0U);
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x2140, 4), 0U);
  EXPECT_EQ(bench.loop->controller().parameters().axis.encoder_resolution_m, 2.0F * resolution_m);
  EXPECT_EQ(bench.read_signed(0x6064, 0), bench.loop->board_encoder.next.counts);
}

// The axis is braked first, by the parameters that it moves by; only then do others come.
TEST(Reset, InMotionTheAxisIsBrakedAndNoFaultRemains) {
  for (const bool restored : {false, true}) {
    Bench bench;
    bench.configure();
    ASSERT_EQ(bench.write(0x1010, 1, kSaveWord, 4), 0U);
    if (restored) {
      ASSERT_EQ(bench.write(0x1011, 1, kLoadWord, 4), 0U);
    }
    start_moving(bench);
    const double from_m = bench.loop->plant.position_m();
    bench.nmt(0x81);
    bench.run_ms(2);
    EXPECT_TRUE(bench.loop->motor.enabled) << "braked, not released";
    // A master that commands at once gets nothing before the axis stands.
    EXPECT_NE(try_to_enable(bench), 0x27U);
    bench.run_ms(150);
    EXPECT_FALSE(bench.loop->motor.enabled);
    EXPECT_LT(std::abs(bench.loop->plant.velocity_mps()), 1e-3);
    EXPECT_LT(bench.loop->plant.position_m() - from_m, 0.0125)
        << "0.3 m/s to rest within 200 m/s3: v sqrt(v / j) = 11.6 mm";
    EXPECT_EQ(bench.read(0x603F, 0), 0U);
    EXPECT_EQ(bench.read(0x2212, 9), 0U) << "no parameter fault";
    EXPECT_EQ(bench.read(0x2140, 2) != 0, !restored);
    EXPECT_EQ(try_to_enable(bench) & 0x4F, restored ? 0x40U : 0x07U);
  }
}

TEST(Reset, AnUncommissionedDriveIsNoFaultAndCanBeCommissionedAgain) {
  Bench bench;
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x603F, 0), 0U);
  bench.configure();
  bench.nmt(0x81);
  bench.run_ms(5);
  EXPECT_EQ(bench.read(0x2140, 2), 0U);
  bench.configure();
  EXPECT_EQ(try_to_enable(bench), 0x27U);
}

}  // namespace
}  // namespace slipstack::can
