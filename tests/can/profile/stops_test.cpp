// SPDX-License-Identifier: Apache-2.0
// The option codes of stops (CiA 402: 605Ah to 605Eh), along which ramp, and where they end.
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kEnabled = 0x27;
constexpr std::uint32_t kSwitchedOn = 0x23;
constexpr std::uint32_t kReady = 0x21;
constexpr std::uint32_t kQuickStopActive = 0x07;
constexpr std::uint32_t kReaction = 0x0F;
constexpr std::uint32_t kFault = 0x08;

class Stops : public ::testing::Test {
 protected:
  Stops() {
    bench_.configure();
    EXPECT_EQ(bench_.write(0x6084, 0, 500000, 4), 0U);   // slow down: 0.5 m/s2
    EXPECT_EQ(bench_.write(0x6085, 0, 2000000, 4), 0U);  // quick stop: 2 m/s2
  }
  std::uint32_t state() {
    const std::uint32_t word = bench_.read(0x6041, 0);
    return (word & 0x08U) != 0 || (word & 0x40U) != 0 ? word & 0x4FU : word & 0x6FU;
  }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  void option(std::uint16_t index, std::uint32_t code) { ASSERT_EQ(bench_.write(index, 0, code, 2), 0U); }
  // At 0.2 m/s in profile position.
  void move() {
    bench_.enable(1);
    ASSERT_EQ(bench_.write(0x6081, 0, 200000, 4), 0U);
    ASSERT_EQ(bench_.write(0x6083, 0, 2000000, 4), 0U);
    const std::int32_t target = bench_.read_signed(0x6064, 0) + 400000;
    ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
    command(0x1F);
    bench_.run_ms(300);
    ASSERT_NEAR(velocity(), 0.2, 0.005);
  }
  void command(std::uint32_t word) { ASSERT_EQ(bench_.write(0x6040, 0, word, 2), 0U); }
  // Milliseconds until the axis stands, and the state is what it ends in; 0 if it is so at once.
  int until(std::uint32_t wanted) {
    for (int ms = 0; ms < 1500; ++ms) {
      if (state() == wanted && std::abs(velocity()) < 2e-3) return ms;
      bench_.run_ms(1);
    }
    ADD_FAILURE() << std::hex << state() << " at " << velocity();
    return -1;
  }
  // From 0.2 m/s: 100 ms at 2 m/s2 and 400 ms at 0.5 m/s2, and the ramps of the jerk, 10 and 2.5 ms and more
  // (60A4h is half of the axis's).
  void expect_quick(int ms) { EXPECT_NEAR(ms, 110, 8); }
  void expect_slow(int ms) { EXPECT_NEAR(ms, 405, 12); }

  Bench bench_;
};

TEST_F(Stops, QuickStop) {
  for (const std::uint32_t code : {1U, 2U, 5U, 6U}) {
    option(0x605A, code);
    move();
    command(0x0B);
    bench_.run_ms(5);
    EXPECT_EQ(state(), kQuickStopActive) << code;
    const int ms = 5 + until(code < 5 ? 0x40 : kQuickStopActive);
    code == 1 || code == 5 ? expect_slow(ms) : expect_quick(ms);
    EXPECT_EQ(bench_.loop->motor.enabled, code >= 5) << code;
    command(0x00);
    bench_.run_ms(10);
  }
}

TEST_F(Stops, DisableOperation) {
  EXPECT_EQ(bench_.read(0x605C, 0), 1U) << "the standard's default";
  move();
  command(0x07);
  bench_.run_ms(5);
  EXPECT_EQ(state(), kEnabled) << "until it stands";
  expect_slow(5 + until(kSwitchedOn));
  EXPECT_FALSE(bench_.loop->motor.enabled);
  option(0x605C, 0);
  move();
  command(0x07);
  bench_.run_ms(1);
  EXPECT_EQ(state(), kSwitchedOn);
  EXPECT_GT(velocity(), 0.15) << "coasts";
  EXPECT_FALSE(bench_.loop->motor.enabled);
}

TEST_F(Stops, Shutdown) {
  EXPECT_EQ(bench_.read(0x605B, 0), 0U) << "the standard's default";
  move();
  command(0x06);
  bench_.run_ms(1);
  EXPECT_EQ(state(), kReady);
  EXPECT_GT(velocity(), 0.15) << "coasts";
  bench_.run_ms(1000);
  option(0x605B, 1);
  move();
  command(0x06);
  bench_.run_ms(5);
  EXPECT_EQ(state(), kEnabled);
  expect_slow(5 + until(kReady));
}

// While operation is being disabled: nothing moves the axis again, a quick stop is quicker, and disable
// voltage does not wait.
TEST_F(Stops, WhatIsMoreUrgentDoesNotWaitForTheRamp) {
  move();
  command(0x07);
  bench_.run_ms(50);
  command(0x1F);  // a set-point now is for nobody
  bench_.run_ms(5);
  EXPECT_LT(velocity(), 0.19);
  command(0x0B);
  bench_.run_ms(1);
  EXPECT_EQ(state(), kQuickStopActive);
  EXPECT_LT(until(0x40), 110);
  move();
  command(0x07);
  bench_.run_ms(50);
  command(0x00);
  bench_.run_ms(1);
  EXPECT_EQ(state(), 0x40U);
  EXPECT_FALSE(bench_.loop->motor.enabled);
}

TEST_F(Stops, Halt) {
  for (const std::uint32_t code : {1U, 2U}) {
    option(0x605D, code);
    move();
    command(0x10F);
    bench_.run_ms(1);
    const int ms = until(kEnabled);
    code == 1 ? expect_slow(ms) : expect_quick(ms);
    const std::int32_t halted = bench_.read_signed(0x6064, 0);
    bench_.run_ms(100);
    EXPECT_NEAR(bench_.read_signed(0x6064, 0), halted, 10);
    command(0x0F);  // the move goes on
    bench_.run_ms(300);
    EXPECT_NEAR(velocity(), 0.2, 0.01) << code;
    command(0x00);
    bench_.run_ms(1000);
  }
}

TEST_F(Stops, HaltInTorqueMode) {
  for (const std::uint32_t code : {1U, 2U}) {
    option(0x605D, code);
    ASSERT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);  // nobody sends commands meanwhile
    bench_.enable(10);
    for (int i = 0; i < 500 && velocity() < 0.2; ++i) {
      ASSERT_EQ(bench_.write(0x6071, 0, 120, 2), 0U);
      bench_.run_ms(1);
    }
    command(0x10F);
    const int ms = until(kEnabled);
    code == 1 ? expect_slow(ms) : expect_quick(ms);
    command(0x00);
    ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
    bench_.run_ms(10);
  }
}

TEST_F(Stops, FaultReaction) {
  for (const std::uint32_t code : {0U, 1U, 2U}) {
    option(0x605E, code);
    move();
    bench_.loop->clock.advance(600);  // a late tick
    bench_.run_ms(1);
    EXPECT_EQ(state(), code == 0 ? kFault : kReaction) << code;
    if (code == 0) {
      EXPECT_GT(velocity(), 0.15) << "coasts";
    } else {
      const int ms = 1 + until(kFault);
      code == 1 ? expect_slow(ms) : expect_quick(ms);
    }
    bench_.run_ms(1000);
    command(0x00);
    command(0x80);
    bench_.run_ms(2);
    command(0x00);
  }
}

// A ramp that takes longer than 2000h:21 as the user asked for it: no fault.
TEST_F(Stops, ALongRampIsNoTimeOut) {
  ASSERT_EQ(bench_.write(0x6085, 0, 100000, 4), 0U);  // 0.1 m/s2: 2 s
  move();
  command(0x0B);
  bench_.run_ms(1800);
  EXPECT_EQ(state(), kQuickStopActive);
  bench_.run_ms(400);
  EXPECT_EQ(state(), 0x40U);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

}  // namespace
}  // namespace slipstack::can
