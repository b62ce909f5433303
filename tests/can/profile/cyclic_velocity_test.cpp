// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous velocity (6060h = 9), the offsets 60B0h and 60B1h. Behind an imperfect bus:
// tests/bench/cyclic_position.
#include <algorithm>
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr int kPeriod_ms = 2;

class CyclicVelocity : public ::testing::Test {
 protected:
  CyclicVelocity() {
    EXPECT_EQ(bench_.write(0x2010, 2, 1, 1), 0U);  // positive limit switch on input 1
    EXPECT_EQ(bench_.write(0x2012, 1, 1, 1), 0U);
    bench_.configure();
    EXPECT_EQ(bench_.write(0x60C2, 1, kPeriod_ms, 1), 0U);
    // RPDO 4: controlword and target velocity, with SYNC.
    for (const auto& [index, sub, value, bytes] : {std::tuple{0x1403, 1, 0x80000505U, 4},
                                                   {0x1403, 2, 1U, 1},
                                                   {0x1603, 0, 0U, 1},
                                                   {0x1603, 1, 0x60400010U, 4},
                                                   {0x1603, 2, 0x60FF0020U, 4},
                                                   {0x1603, 0, 2U, 1},
                                                   {0x1403, 1, 0x505U, 4}})
      EXPECT_EQ(bench_.write(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub), value, bytes),
                0U);
    home_ = bench_.read_signed(0x6064, 0);
    bench_.nmt(0x01);
  }
  void sync() { bench_.send(0x080, {}); }
  // A set-point and SYNC, then a period.
  void period(std::int32_t wanted, std::uint16_t word = 0x0F) {
    const auto bits = static_cast<std::uint32_t>(wanted);
    bench_.send(0x505, {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8),
                        static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                        static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)});
    sync();
    bench_.run_ms(kPeriod_ms);
  }
  void periods(int number, std::int32_t wanted) {
    for (int i = 0; i < number; ++i) period(wanted);
  }
  void silent(int number) {
    for (int i = 0; i < number; ++i) {
      sync();
      bench_.run_ms(kPeriod_ms);
    }
  }
  void target(std::int32_t wanted) {
    ASSERT_EQ(bench_.write(0x60FF, 0, static_cast<std::uint32_t>(wanted), 4), 0U);
  }
  std::int32_t position() { return bench_.read_signed(0x6064, 0) - home_; }
  std::int32_t demand() { return bench_.read_signed(0x606B, 0); }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  bool bit(int number) { return (bench_.read(0x6041, 0) >> number & 1U) != 0; }

  Bench bench_;
  std::int32_t home_ = 0;
};

TEST_F(CyclicVelocity, FollowsAtSync) {
  bench_.enable(9);
  EXPECT_EQ(bench_.read(0x6061, 0), 9U);
  double sum = 0.0, largest = 0.0;
  std::array<double, 520> wanted{};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] =
        i < 20 ? 0.0 : 50000.0 * (1.0 - std::cos(2.0 * M_PI * (static_cast<double>(i) - 20.0) / 250.0));
    period(static_cast<std::int32_t>(std::lround(wanted[i])));
    sum += std::round(wanted[i]) * 1e-3 * kPeriod_ms;
    // A set-point is followed two periods and a half after it; half a one has run since the last was taken,
    // at the first poll.
    if (i > 30) largest = std::max(largest, std::abs(demand() - wanted[i - 2]));
    ASSERT_LT(std::abs(bench_.read_signed(0x60F4, 0)), 30) << i;
  }
  EXPECT_LT(largest, 200.0) << "0.63 m/s2 for a tick and a bit: 0.13 mm/s";
  EXPECT_TRUE(bit(12));
  EXPECT_EQ(bench_.read(0x2211, 8), 0U);
  // Every set-point counts for a period, none more or less.
  periods(20, 0);
  EXPECT_NEAR(position(), sum, 10.0);
}

TEST_F(CyclicVelocity, WithoutASetPointTheAxisStays) {
  target(100000);
  ASSERT_EQ(bench_.write(0x60B1, 0, 100000, 4), 0U);
  silent(20);
  bench_.enable(9);
  EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  silent(100);
  EXPECT_NEAR(position(), 0, 15);
  EXPECT_FALSE(bit(12));
}

// Written by SDO it holds: every SYNC makes a set-point of it.
TEST_F(CyclicVelocity, ATargetBySdoHolds) {
  ASSERT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);
  bench_.enable(9);
  silent(20);
  target(100000);
  silent(100);
  EXPECT_NEAR(velocity(), 0.1, 0.003);
  ASSERT_EQ(bench_.write(0x60B1, 0, static_cast<std::uint32_t>(-150000), 4), 0U);
  silent(100);
  EXPECT_NEAR(velocity(), -0.05, 0.003);
  EXPECT_EQ(demand(), -50000);
}

// A step of the target is a ramp within the axis's acceleration, and the position it costs is not caught up
// with.
TEST_F(CyclicVelocity, AStepIsARampAndNotCaughtUpWith) {
  bench_.enable(9);
  periods(20, 0);
  std::int32_t before = 0, largest = 0, fastest = 0;
  for (int i = 0; i < 100; ++i) {
    period(200000);
    const std::int32_t now = demand();
    largest = std::max(largest, now - before);
    fastest = std::max(fastest, now);
    before = now;
    if (i == 5) {
      EXPECT_TRUE(bit(11));
    }
  }
  EXPECT_LE(largest, 5000000 * kPeriod_ms / 1000 + 100) << "5 m/s2";
  EXPECT_GT(largest, 4900000 * kPeriod_ms / 1000);
  EXPECT_LE(fastest, 200005);
  EXPECT_FALSE(bit(11));
  // 607Fh, and what the axis can: 0.3 m/s.
  periods(100, 1000000);
  EXPECT_NEAR(demand(), 300000, 10);
  EXPECT_TRUE(bit(11));
  ASSERT_EQ(bench_.write(0x607F, 0, 120000, 4), 0U);
  periods(100, 1000000);
  EXPECT_NEAR(demand(), 120000, 10);
  ASSERT_EQ(bench_.write(0x60C6, 0, 1000000, 4), 0U);
  before = demand();
  for (int i = 0; i < 10; ++i) period(0);
  EXPECT_NEAR(demand(), before - 8 * 2000, 2500);
}

TEST_F(CyclicVelocity, StopsAtTheEndOfTheRangeAndComesBackAtOnce) {
  ASSERT_EQ(bench_.write(0x607D, 2, static_cast<std::uint32_t>(home_ + 60000), 4), 0U);
  bench_.enable(9);
  std::int32_t farthest = 0;
  for (int i = 0; i < 500; ++i) {
    period(std::min(4000 * i, 200000));
    farthest = std::max(farthest, position());
  }
  EXPECT_LE(farthest, 60020);
  EXPECT_NEAR(position(), 60000, 20);
  EXPECT_TRUE(bit(11));
  periods(40, -200000);
  EXPECT_LT(velocity(), -0.15) << "nothing has been summed up meanwhile";
  EXPECT_FALSE(bit(11));
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(CyclicVelocity, ALimitSwitchStopsItInItsDirectionOnly) {
  bench_.enable(9);
  for (int i = 0; i < 200; ++i) period(std::min(4000 * i, 200000));
  ASSERT_NEAR(velocity(), 0.2, 0.01);
  bench_.loop->io.inputs = 1;
  const std::int32_t at = position();
  periods(200, 200000);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_NEAR(position(), at + 6320, 300) << "v sqrt(v / j), as every stop";
  EXPECT_TRUE(bit(11));
  periods(100, -100000);
  EXPECT_NEAR(velocity(), -0.1, 0.003);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(CyclicVelocity, HaltAndOn) {
  bench_.enable(9);
  for (int i = 0; i < 200; ++i) period(std::min(4000 * i, 200000));
  for (int i = 0; i < 200; ++i) period(200000, 0x010F);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_FALSE(bit(12));
  const std::int32_t stands = position();
  ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
  EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  silent(10);
  EXPECT_NEAR(position(), stands, 5) << "not before the next set-point";
  periods(100, 100000);
  EXPECT_NEAR(velocity(), 0.1, 0.003);
}

// The cable is out: first the gap is a stop, then the command time-out ends operation.
TEST_F(CyclicVelocity, AMasterThatFallsSilent) {
  bench_.enable(9);
  for (int i = 0; i < 200; ++i) period(std::min(4000 * i, 200000));
  const std::int32_t from = position();
  bench_.run_ms(40);
  EXPECT_EQ(bench_.read(0x2211, 8), 1U);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x27U);
  bench_.run_ms(200);
  EXPECT_FALSE(bench_.loop->motor.enabled);
  EXPECT_EQ(bench_.read(0x603F, 0), 0x8100U);
  // Five periods, and v sqrt(v / j).
  EXPECT_LT(position() - from, 2000 + 6400 + 600);
}

// A master that changes its period in motion: the stream ends with the lock, a stop that 2211h:08 counts.
TEST_F(CyclicVelocity, AMasterThatChangesItsPeriod) {
  bench_.enable(9);
  for (int i = 0; i < 200; ++i) period(std::min(4000 * i, 200000));
  ASSERT_TRUE(bit(12));
  EXPECT_EQ(bench_.read(0x2211, 8), 0U);
  for (int i = 0; i < 100; ++i) {
    period(200000);
    bench_.run_ms(kPeriod_ms / 2);
  }
  EXPECT_FALSE(bit(12));
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_EQ(bench_.read(0x2211, 8), 1U);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U) << "set-points come: no fault";
  // As agreed again.
  periods(100, 200000);
  EXPECT_NEAR(velocity(), 0.2, 0.01);
  EXPECT_EQ(bench_.read(0x2211, 8), 1U);
}

// Cyclic position: the target is 607Ah and 60B0h together.
TEST_F(CyclicVelocity, ThePositionOffsetCountsInCyclicPosition) {
  ASSERT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);
  ASSERT_EQ(bench_.write(0x60B0, 0, 7000, 4), 0U);
  silent(20);
  bench_.enable(8);
  silent(50);
  EXPECT_NEAR(position(), 0, 15) << "nothing was commanded";
  ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(home_ + 1000), 4), 0U);
  silent(200);
  EXPECT_NEAR(position(), 8000, 5);
  ASSERT_EQ(bench_.write(0x60B0, 0, static_cast<std::uint32_t>(-3000), 4), 0U);
  silent(200);
  EXPECT_NEAR(position(), -2000, 5);
}

}  // namespace
}  // namespace slipstack::can
