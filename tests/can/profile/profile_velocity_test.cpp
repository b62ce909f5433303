// SPDX-License-Identifier: Apache-2.0
// Profile velocity (6060h = 3): its ramps, its bits of the statusword, and everything that ends a motion
// which does not end by itself.
#include <algorithm>
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

class ProfileVelocity : public ::testing::Test {
 protected:
  ProfileVelocity() {
    // Positive limit switch on input 1, active while high; an absolute encoder.
    EXPECT_EQ(bench_.write(0x2010, 2, 1, 1), 0U);
    EXPECT_EQ(bench_.write(0x2012, 1, 1, 1), 0U);
    bench_.configure();
    EXPECT_EQ(bench_.write(0x6083, 0, 1000000, 4), 0U);
    EXPECT_EQ(bench_.write(0x6084, 0, 2000000, 4), 0U);
    EXPECT_EQ(bench_.write(0x60A4, 1, 100000000, 4), 0U);
    home_ = bench_.read_signed(0x6064, 0);
  }
  void target(std::int32_t wanted) {
    ASSERT_EQ(bench_.write(0x60FF, 0, static_cast<std::uint32_t>(wanted), 4), 0U);
  }
  void controlword(std::uint32_t word) { ASSERT_EQ(bench_.write(0x6040, 0, word, 2), 0U); }
  std::int32_t demand() { return bench_.read_signed(0x606B, 0); }
  std::int32_t actual() { return bench_.read_signed(0x606C, 0); }
  std::int32_t position() { return bench_.read_signed(0x6064, 0) - home_; }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  bool bit(int number) { return (bench_.read(0x6041, 0) >> number & 1U) != 0; }
  std::uint32_t state() { return bench_.read(0x6041, 0) & 0x6F; }
  void range(std::int32_t low, std::int32_t high) {
    ASSERT_EQ(bench_.write(0x607D, 1, static_cast<std::uint32_t>(home_ + low), 4), 0U);
    ASSERT_EQ(bench_.write(0x607D, 2, static_cast<std::uint32_t>(home_ + high), 4), 0U);
  }
  // Milliseconds until the reference has this velocity.
  int time_to(std::int32_t wanted) {
    int milliseconds = 0;
    for (; milliseconds < 3000 && std::abs(demand() - wanted) > 1; ++milliseconds) bench_.run_ms(1);
    return milliseconds;
  }

  Bench bench_;
  std::int32_t home_ = 0;
};

TEST_F(ProfileVelocity, ReachesKeepsAndChangesItsVelocity) {
  bench_.enable(3);
  EXPECT_EQ(bench_.read(0x6061, 0), 3U);
  EXPECT_TRUE(bit(12)) << "it stands";
  target(100000);
  EXPECT_FALSE(bit(10));
  // v / a + a / j = 0.1 / 1 + 1 / 100 s, and until the tick has taken the plan over.
  EXPECT_NEAR(time_to(100000), 110, 5);
  bench_.run_ms(30);
  EXPECT_TRUE(bit(10));
  EXPECT_FALSE(bit(12));
  EXPECT_NEAR(actual(), 100000, 3000);
  const std::int32_t from = position();
  bench_.run_ms(500);
  EXPECT_NEAR(position() - from, 50000, 100);
  EXPECT_EQ(demand(), 100000);
  // Slower, along 6084h: 0.06 / 2 + 2 / 100 does not reach the deceleration, 2 sqrt(0.06 / 100).
  target(40000);
  EXPECT_FALSE(bit(10));
  EXPECT_NEAR(time_to(40000), 49, 6);
  // Through zero to the other direction, then to rest.
  target(-100000);
  EXPECT_NEAR(time_to(-100000), 140, 30);
  bench_.run_ms(30);
  EXPECT_TRUE(bit(10));
  EXPECT_NEAR(actual(), -100000, 3000);
  target(0);
  time_to(0);
  bench_.run_ms(30);
  EXPECT_TRUE(bit(10));
  EXPECT_TRUE(bit(12));
  EXPECT_EQ(demand(), 0);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
  EXPECT_FALSE(bit(11));
}

// 6083h and its relatives may change on the way: what was planned is planned anew.
TEST_F(ProfileVelocity, ProfileAndBoundsHoldAtOnce) {
  bench_.enable(3);
  ASSERT_EQ(bench_.write(0x6083, 0, 100000, 4), 0U);
  target(200000);
  bench_.run_ms(200);
  EXPECT_LT(demand(), 25000);
  ASSERT_EQ(bench_.write(0x6083, 0, 2000000, 4), 0U);
  EXPECT_LT(time_to(200000), 150);
  // Bounds: the largest velocities, and the largest accelerations.
  ASSERT_EQ(bench_.write(0x607F, 0, 120000, 4), 0U);
  EXPECT_LT(time_to(120000), 150);
  EXPECT_TRUE(bit(11));
  bench_.run_ms(30);
  EXPECT_FALSE(bit(10)) << "it is not the target";
  ASSERT_EQ(bench_.write(0x6080, 0, 60, 4), 0U);
  EXPECT_LT(time_to(60000), 150);
  ASSERT_EQ(bench_.write(0x60C6, 0, 100000, 4), 0U);
  target(20000);
  EXPECT_NEAR(time_to(20000), 400, 10) << "0.04 / 0.1, and 0.1 / 100";
  EXPECT_FALSE(bit(11));
  ASSERT_EQ(bench_.write(0x60C5, 0, 200000, 4), 0U);
  target(60000);
  EXPECT_NEAR(time_to(60000), 204, 10);
}

// 606Dh to 6070h, from both sides.
TEST_F(ProfileVelocity, WindowsAndTheirTimes) {
  ASSERT_EQ(bench_.write(0x606D, 0, 20000, 2), 0U);
  ASSERT_EQ(bench_.write(0x606E, 0, 200, 2), 0U);
  ASSERT_EQ(bench_.write(0x606F, 0, 50000, 2), 0U);
  ASSERT_EQ(bench_.write(0x6070, 0, 100, 2), 0U);
  bench_.enable(3);
  target(100000);
  int reached = 0, inside = 0, fast = 0, above = 0;
  for (int ms = 1; ms < 600; ++ms) {
    bench_.run_ms(1);
    const std::int32_t now = actual();
    if (inside == 0 && now > 80000) inside = ms;
    if (reached == 0 && bit(10)) reached = ms;
    if (above == 0 && now > 50000) above = ms;
    if (fast == 0 && !bit(12)) fast = ms;
  }
  EXPECT_NEAR(reached - inside, 200, 8);
  EXPECT_NEAR(fast - above, 100, 8);
  // Slower than the threshold: at once.
  target(0);
  for (int ms = 0; ms < 600 && actual() > 50000; ++ms) bench_.run_ms(1);
  bench_.run_ms(1);
  EXPECT_TRUE(bit(12));
  // FFFFh: when the reference has it.
  ASSERT_EQ(bench_.write(0x606D, 0, 0xFFFF, 2), 0U);
  ASSERT_EQ(bench_.write(0x606E, 0, 0, 2), 0U);
  target(30000);
  bench_.run_ms(5);
  EXPECT_FALSE(bit(10)) << "no window of 65535";
  const int arrived = time_to(30000);
  EXPECT_GT(arrived, 30);
  bench_.run_ms(2);
  EXPECT_TRUE(bit(10));
}

// No velocity holds from before: neither from another mode, nor from before enabling.
TEST_F(ProfileVelocity, StartsAtNoVelocity) {
  target(200000);
  bench_.enable(3);
  bench_.run_ms(100);
  EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  EXPECT_NEAR(position(), 0, 15);
  target(100000);
  bench_.run_ms(200);
  controlword(0x06);
  bench_.run_ms(500);
  controlword(0x07);
  bench_.run_ms(2);
  controlword(0x0F);
  bench_.run_ms(100);
  EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  target(100000);
  bench_.run_ms(200);
  EXPECT_GT(velocity(), 0.09);
  ASSERT_EQ(bench_.write(0x6060, 0, 1, 1), 0U);
  EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  ASSERT_EQ(bench_.write(0x6060, 0, 3, 1), 0U);
  bench_.run_ms(500);
  EXPECT_LT(std::abs(velocity()), 1e-3);
}

TEST_F(ProfileVelocity, HaltAlongEitherRampAndOn) {
  ASSERT_EQ(bench_.write(0x6084, 0, 500000, 4), 0U);
  for (const std::uint32_t option : {1U, 2U}) {
    ASSERT_EQ(bench_.write(0x605D, 0, option, 2), 0U);
    bench_.enable(3);
    target(200000);
    bench_.run_ms(400);
    ASSERT_NEAR(velocity(), 0.2, 0.01);
    controlword(0x010F);
    int ms = 0;
    for (; ms < 1000 && demand() != 0; ++ms) bench_.run_ms(1);
    // 0.2 / 0.5 + 0.5 / 100; the quick stop at 200 m/s3: 2 sqrt(0.2 / 200).
    EXPECT_NEAR(ms, option == 1 ? 405 : 63, option == 1 ? 8 : 5) << option;
    bench_.run_ms(20);
    EXPECT_TRUE(bit(10));
    const std::int32_t stands = position();
    bench_.run_ms(200);
    EXPECT_NEAR(position(), stands, 5);
    EXPECT_EQ(bench_.read_signed(0x60FF, 0), 200000);
    controlword(0x0F);
    bench_.run_ms(400);
    EXPECT_NEAR(velocity(), 0.2, 0.01) << "it goes on";
    target(0);
    bench_.run_ms(600);
    controlword(0x06);
    bench_.run_ms(5);
  }
}

// At the end of the range it has come to rest in time, and stays until it is asked back, even if the range
// becomes wider: who stands there has seen the axis end.
TEST_F(ProfileVelocity, RestsAtASoftwareLimitAndLeavesItInwards) {
  range(-20000, 60000);
  bench_.enable(3);
  target(200000);
  std::int32_t farthest = -1000000;
  for (int ms = 0; ms < 1200; ++ms) {
    bench_.run_ms(1);
    farthest = std::max(farthest, position());
  }
  EXPECT_LE(farthest, 60010);
  EXPECT_NEAR(position(), 60000, 5);
  EXPECT_TRUE(bit(11));
  EXPECT_FALSE(bit(10));
  EXPECT_TRUE(bit(12));
  range(-20000, 90000);
  target(150000);
  bench_.run_ms(300);
  EXPECT_NEAR(position(), 60000, 5);
  target(0);
  bench_.run_ms(5);
  EXPECT_FALSE(bit(11));
  target(150000);
  bench_.run_ms(900);
  EXPECT_NEAR(position(), 90000, 5);
  target(-200000);
  bench_.run_ms(2000);
  EXPECT_NEAR(position(), -20000, 5);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(ProfileVelocity, ARangeThatBecomesNarrowerIsKept) {
  bench_.enable(3);
  target(200000);
  bench_.run_ms(400);
  range(-20000, position() + 25000);
  std::int32_t farthest = -1000000;
  const std::int32_t end = bench_.read_signed(0x607D, 2) - home_;
  for (int ms = 0; ms < 800; ++ms) {
    bench_.run_ms(1);
    farthest = std::max(farthest, position());
  }
  EXPECT_LE(farthest, end + 10);
  EXPECT_NEAR(position(), end, 10);
}

TEST_F(ProfileVelocity, ALimitSwitchEndsTheTravelEvenIfItBounces) {
  bench_.enable(3);
  target(200000);
  bench_.run_ms(400);
  bench_.loop->io.inputs = 1;
  const std::int32_t at = position();
  bench_.run_ms(300);
  EXPECT_LT(std::abs(velocity()), 1e-3);
  EXPECT_LT(position() - at, 15000) << "the quick stop ramp";
  EXPECT_TRUE(bit(11));
  const std::int32_t stopped = position();
  for (int bounce = 0; bounce < 20; ++bounce) {
    bench_.loop->io.inputs = bounce % 2 == 0 ? 0 : 1;
    target(200000 + bounce);
    bench_.run_ms(10);
  }
  EXPECT_NEAR(position(), stopped, 5);
  target(-200000);
  bench_.run_ms(200);
  EXPECT_LT(velocity(), -0.15) << "the way back is free";
  bench_.loop->io.inputs = 0;
  bench_.run_ms(5);
  target(200000);
  bench_.run_ms(500);
  EXPECT_GT(velocity(), 0.19);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

// New targets every millisecond, faster than plans are taken over: it follows all the same.
TEST_F(ProfileVelocity, FollowsAStreamOfTargets) {
  bench_.enable(3);
  double largest = 0.0;
  for (int ms = 0; ms < 2000; ++ms) {
    const double wanted = 100000.0 * std::sin(2.0 * M_PI * ms / 1000.0);
    target(static_cast<std::int32_t>(wanted));
    bench_.run_ms(1);
    if (ms > 100) largest = std::max(largest, std::abs(demand() - wanted));
  }
  // 0.63 m/s2 and less than 20 ms: two plans, and the jerk.
  EXPECT_LT(largest, 13000.0);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

// A target velocity is written once and holds, with the command time-out as delivered: the mode is not
// cyclic.
TEST_F(ProfileVelocity, ATargetThatIsWrittenOnceHolds) {
  ASSERT_EQ(bench_.read(0x2403, 0), 50U);
  bench_.enable(3);
  target(50000);
  bench_.run_ms(1500);
  EXPECT_EQ(state(), 0x27U);
  EXPECT_NEAR(velocity(), 0.05, 0.002);
  // On the way to a cyclic mode it slows down, and nothing is awaited before the first set-point.
  ASSERT_EQ(bench_.write(0x6060, 0, 9, 1), 0U);
  bench_.run_ms(500);
  EXPECT_EQ(state(), 0x27U);
  EXPECT_LT(std::abs(velocity()), 1e-3);
}

// What ends it is the loss of communication: as delivered that nobody acknowledges what the node sends (the
// cable is pulled), or that the bus is off; set up, the master's heartbeat. 6007h says how.
TEST_F(ProfileVelocity, LostCommunicationStopsIt) {
  enum class Loss { kCable, kBusOff, kHeartbeat };
  for (const Loss loss : {Loss::kCable, Loss::kBusOff, Loss::kHeartbeat}) {
    ASSERT_EQ(bench_.write(0x1016, 1, loss == Loss::kHeartbeat ? (127U << 16) | 100U : 0U, 4), 0U);
    bench_.enable(3);
    target(200000);
    for (int i = 0; i < 20; ++i) {
      bench_.send(0x77F, {0x05});
      bench_.run_ms(20);
    }
    ASSERT_GT(velocity(), 0.19);
    const std::int32_t from = position();
    if (loss == Loss::kCable) bench_.device.bus.state = CanBusState::kPassive;
    if (loss == Loss::kBusOff) bench_.device.bus.state = CanBusState::kOff;
    bench_.run_ms(500);
    bench_.device.bus.state = CanBusState::kActive;
    EXPECT_FALSE(bench_.loop->motor.enabled) << static_cast<int>(loss);
    EXPECT_LT(std::abs(velocity()), 1e-3);
    // v sqrt(v / j) = 6 mm, and 100 ms at 0.2 m/s.
    EXPECT_LT(position() - from, loss == Loss::kHeartbeat ? 28000 : 7000) << static_cast<int>(loss);
    bench_.run_ms(300);
    bench_.all();
    ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(home_), 4), 0U);
    bench_.enable(1);
    controlword(0x1F);
    bench_.run_ms(2500);
    controlword(0x06);
    bench_.run_ms(5);
  }
}

// At rest nobody is missed.
TEST_F(ProfileVelocity, AtRestAPassiveBusIsNoReasonToStop) {
  bench_.enable(3);
  bench_.run_ms(20);
  bench_.device.bus.state = CanBusState::kPassive;
  bench_.run_ms(100);
  bench_.device.bus.state = CanBusState::kActive;
  EXPECT_EQ(state(), 0x27U);
}

TEST_F(ProfileVelocity, QuickStopAndFaultReactionBrakeIt) {
  for (const bool fault : {false, true}) {
    bench_.enable(3);
    target(200000);
    bench_.run_ms(400);
    ASSERT_GT(velocity(), 0.19);
    const std::int32_t from = position();
    if (fault) {
      bench_.loop->clock.advance(600);  // a tick that comes late
      bench_.loop->step();
    } else {
      controlword(0x0B);
    }
    bench_.run_ms(300);
    EXPECT_FALSE(bench_.loop->motor.enabled);
    EXPECT_LT(std::abs(velocity()), 2e-3);
    EXPECT_LT(position() - from, 12000);
    EXPECT_EQ(bench_.read_signed(0x60FF, 0), 0);
  }
}

TEST_F(ProfileVelocity, PolarityAndUnitsOfTheUser) {
  ASSERT_EQ(bench_.write(0x608F, 1, 2, 4), 0U);  // 2 counts a unit
  ASSERT_EQ(bench_.write(0x607E, 0, 0x40, 1), 0U);
  bench_.enable(3);
  target(50000);
  bench_.run_ms(300);
  EXPECT_NEAR(velocity(), -0.1, 0.003);
  EXPECT_EQ(demand(), 50000);
  EXPECT_NEAR(actual(), 50000, 2000);
  EXPECT_TRUE(bit(10));
}

// A ramp beyond the arithmetic is a fault, never a silent standstill.
TEST_F(ProfileVelocity, ARampThatCannotBePlannedIsAFault) {
  ASSERT_EQ(bench_.write(0x6083, 0, 1, 4), 0U);
  bench_.enable(3);
  target(200000);
  bench_.run_ms(5);
  EXPECT_EQ(bench_.read(0x603F, 0), 0x8600U);
}

}  // namespace
}  // namespace slipstack::can
