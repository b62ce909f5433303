// SPDX-License-Identifier: Apache-2.0
// Limits of position and velocity (607Dh, 607Fh, 6080h, limit switches) in each mode, and the brake's
// sequence.
#include <algorithm>
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

class Limits : public ::testing::Test {
 protected:
  Limits() {
    // Positive limit switch on input 1, brake on output 1; both active while high.
    EXPECT_EQ(bench_.write(0x2010, 2, 1, 1), 0U);
    EXPECT_EQ(bench_.write(0x2010, 6, 1, 1), 0U);
    EXPECT_EQ(bench_.write(0x2012, 1, 1, 1),
              0U);  // an absolute encoder: positions bound where they are known
    bench_.configure();
    home_ = bench_.read_signed(0x6064, 0);
    EXPECT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);
    EXPECT_EQ(bench_.write(0x6081, 0, 200000, 4), 0U);
  }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  std::int32_t position() { return bench_.read_signed(0x6064, 0); }
  bool limited() { return (bench_.read(0x6041, 0) & 0x0800U) != 0; }
  bool released() const { return (bench_.loop->io.outputs & 1U) != 0; }
  void range(std::int32_t low, std::int32_t high) {
    ASSERT_EQ(bench_.write(0x607D, 1, static_cast<std::uint32_t>(home_ + low), 4), 0U);
    ASSERT_EQ(bench_.write(0x607D, 2, static_cast<std::uint32_t>(home_ + high), 4), 0U);
  }
  void go(std::int32_t way, std::uint32_t word = 0x3F) {
    ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(home_ + way), 4), 0U);
    ASSERT_EQ(bench_.write(0x6040, 0, word, 2), 0U);
    bench_.run_ms(1);
    ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
  }
  void push(int thousandths) {
    ASSERT_EQ(bench_.write(0x6071, 0, static_cast<std::uint32_t>(thousandths), 2), 0U);
  }
  // The farthest place from home on the way, counts.
  std::int32_t farthest(int milliseconds) {
    std::int32_t most = -1000000;
    for (int ms = 0; ms < milliseconds; ++ms) {
      bench_.run_ms(1);
      most = std::max(most, position() - home_);
    }
    return most;
  }

  Bench bench_;
  std::int32_t home_ = 0;
};

// The position of an incremental encoder that was not homed says nothing about the rail.
TEST_F(Limits, WithoutAReferenceTheRangeBoundsNothing) {
  range(-10000, 20000);
  bench_.loop->controller().position().lose();
  bench_.enable(1);
  go(30000);
  EXPECT_FALSE(limited());
  bench_.run_ms(800);
  EXPECT_NEAR(position() - home_, 30000, 5);
}

TEST_F(Limits, ATargetBeyondTheRangeIsTakenToItsEnd) {
  range(-10000, 20000);
  bench_.enable(1);
  EXPECT_FALSE(limited());
  go(50000);
  EXPECT_TRUE(limited());
  EXPECT_LE(farthest(800), 20005);
  EXPECT_NEAR(position() - home_, 20000, 5);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
  go(-50000);
  bench_.run_ms(1000);
  EXPECT_NEAR(position() - home_, -10000, 5);
  go(0);
  bench_.run_ms(500);
  EXPECT_NEAR(position() - home_, 0, 5);
  EXPECT_FALSE(limited());
}

// Retargeted to a place that the present motion would overshoot, beyond the limit: it brakes harder instead.
TEST_F(Limits, ARetargetedMoveDoesNotOvershootTheRange) {
  ASSERT_EQ(bench_.write(0x6084, 0, 400000, 4), 0U);  // 0.4 m/s2: 50 mm from 0.2 m/s
  range(-10000, 45000);
  bench_.enable(1);
  go(45000);
  bench_.run_ms(1);
  ASSERT_EQ(bench_.write(0x6084, 0, 400000, 4), 0U);
  while (position() - home_ < 15000) bench_.run_ms(1);
  range(-10000, 38000);
  go(38000);
  EXPECT_LE(farthest(1500), 38010);
  EXPECT_NEAR(position() - home_, 38000, 10);
}

TEST_F(Limits, ARangeThatBecomesNarrowerHoldsForTheMoveUnderWay) {
  bench_.enable(1);
  go(100000);
  bench_.run_ms(150);
  range(-10000, 60000);
  EXPECT_LE(farthest(800), 60010);
  EXPECT_NEAR(position() - home_, 60000, 10);
  EXPECT_TRUE(limited());
}

TEST_F(Limits, InTorqueModeTheAxisBrakesInTimeAndIsHeld) {
  range(-30000, 60000);
  bench_.enable(10);
  push(200);
  EXPECT_LE(farthest(1500), 60010);
  EXPECT_GT(position() - home_, 50000);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_TRUE(limited());
  // Away from the limit the force acts again; and so to the other end.
  push(-200);
  bench_.run_ms(100);
  EXPECT_LT(velocity(), -0.05);
  std::int32_t lowest = 0;
  for (int ms = 0; ms < 1500; ++ms) {
    bench_.run_ms(1);
    lowest = std::min(lowest, position() - home_);
  }
  EXPECT_GE(lowest, -30010);
  EXPECT_LT(lowest, -20000);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(Limits, VelocityInTorqueMode) {
  ASSERT_EQ(bench_.write(0x6080, 0, 100, 4), 0U);  // mm/s
  bench_.enable(10);
  push(300);
  double fastest = 0.0;
  for (int ms = 0; ms < 1000; ++ms) {
    bench_.run_ms(1);
    fastest = std::max(fastest, std::abs(velocity()));
  }
  EXPECT_LT(fastest, 0.105);
  EXPECT_GT(fastest, 0.09);
  EXPECT_TRUE(limited());
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(Limits, VelocityOfMoves) {
  for (const std::uint16_t index : {std::uint16_t{0x607F}, std::uint16_t{0x6080}}) {
    ASSERT_EQ(bench_.write(0x607F, 0, 0xFFFFFFFF, 4), 0U);
    ASSERT_EQ(bench_.write(index, 0, index == 0x607F ? 50000 : 50, 4), 0U);
    bench_.enable(1);
    go(position() - home_ + 30000);
    bench_.run_ms(200);
    EXPECT_NEAR(bench_.read_signed(0x606C, 0), 50000, 2500);
    bench_.run_ms(800);
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
    bench_.run_ms(2);
  }
}

TEST_F(Limits, ALimitSwitchStopsTheAxisInItsDirectionOnly) {
  bench_.enable(1);
  go(100000);
  bench_.run_ms(250);
  ASSERT_GT(velocity(), 0.19);
  bench_.loop->io.inputs = 1;
  const std::int32_t at = position();
  bench_.run_ms(300);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_LT(position() - at, 15000) << "v sqrt(v / j) = 6 mm, and what the slower of the ramps adds";
  EXPECT_TRUE(limited());
  const std::int32_t stopped = position();
  go(150000);
  bench_.run_ms(300);
  EXPECT_LE(position(), stopped + 5);
  go(0);
  bench_.run_ms(1500);
  EXPECT_NEAR(position() - home_, 0, 5);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

// Current, brake open, operation enabled; standstill, brake closed, current off. Delays of 2408h.
TEST_F(Limits, TheBrakeOpensBeforeAndClosesAfterMotion) {
  ASSERT_EQ(bench_.write(0x2408, 1, 30, 2), 0U);
  ASSERT_EQ(bench_.write(0x2408, 2, 50, 2), 0U);
  ASSERT_EQ(bench_.write(0x6060, 0, 1, 1), 0U);
  for (const std::uint32_t word : {0x06U, 0x07U}) {
    ASSERT_EQ(bench_.write(0x6040, 0, word, 2), 0U);
    bench_.run_ms(1);
  }
  EXPECT_FALSE(released());
  ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
  bench_.run_ms(28);
  EXPECT_TRUE(bench_.loop->motor.enabled);
  EXPECT_TRUE(released());
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x23U) << "not yet";
  bench_.run_ms(4);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x27U);
  go(50000);
  bench_.run_ms(200);
  ASSERT_EQ(bench_.write(0x6040, 0, 0x0B, 2), 0U);
  bench_.run_ms(1);
  for (int ms = 0; ms < 300 && released(); ++ms) {
    EXPECT_TRUE(bench_.loop->motor.enabled);
    bench_.run_ms(1);
  }
  EXPECT_FALSE(released());
  EXPECT_LT(std::abs(velocity()), 2e-3);
  bench_.run_ms(45);
  EXPECT_TRUE(bench_.loop->motor.enabled) << "holds until the brake does";
  bench_.run_ms(10);
  EXPECT_FALSE(bench_.loop->motor.enabled);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x4F, 0x40U);
}

// The encoder is an absolute one: three of its readings are bridged (2012h:06).
TEST_F(Limits, WithoutAPositionTheBrakeClosesAtOnce) {
  ASSERT_EQ(bench_.write(0x2408, 2, 50, 2), 0U);
  bench_.enable(1);
  go(100000);
  bench_.run_ms(200);
  EXPECT_TRUE(released());
  bench_.loop->board_encoder.next.valid = false;
  for (int bridged = 0; bridged < 3; ++bridged) bench_.loop->step();
  EXPECT_TRUE(released());
  bench_.loop->step();
  EXPECT_FALSE(released());
  EXPECT_FALSE(bench_.loop->motor.enabled);
}

TEST_F(Limits, AStreamStopsAtTheEndAndComesBack) {
  range(-10000, 30000);
  ASSERT_EQ(bench_.write(0x60C2, 1, 2, 1), 0U);
  bench_.nmt(0x01);
  bench_.enable(8);
  double wanted = home_;
  std::int32_t highest = home_;
  for (int i = 0; i < 800; ++i) {
    wanted += i < 400 ? 150.0 * std::min(1.0, i / 50.0) : -150.0;
    if (i == 400) wanted = home_ + 30000;
    const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(wanted));
    bench_.send(0x305, {0x0F, 0x00, static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                        static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)});
    bench_.send(0x080, {});
    bench_.run_ms(2);
    highest = std::max(highest, position());
    if (i == 398) {
      EXPECT_NEAR(position() - home_, 30000, 20);
      EXPECT_TRUE(limited());
    }
    if (i == 600) {
      EXPECT_FALSE(limited());
    }
  }
  EXPECT_LE(highest - home_, 30020);
  EXPECT_NEAR(position() - home_, -10000, 20);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

}  // namespace
}  // namespace slipstack::can
