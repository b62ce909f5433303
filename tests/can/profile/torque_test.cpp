// SPDX-License-Identifier: Apache-2.0
// Cyclic synchronous torque, torque offset, and the option codes that go with them, on the simulated axis.
#include <cmath>
#include <functional>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint8_t kPosition = 1;
constexpr std::uint8_t kCyclicPosition = 8;
constexpr std::uint8_t kTorque = 10;

class Torque : public ::testing::Test {
 protected:
  Torque() {
    bench_.configure();
    // A force is written once and acts for seconds here (2403h:
    // tests/can/connection_supervision/command_timeout_test.cpp).
    EXPECT_EQ(bench_.write(0x2403, 0, 0, 2), 0U);
    const AxisParameters& axis = bench_.loop->controller().parameters().axis;
    per_newton_ = 1.0F / axis.motor_constant_N_per_A;
    rated_N_ = static_cast<float>(bench_.read(0x6076, 0)) * 1e-3F;
    home_ = bench_.read_signed(0x6064, 0);
  }

  std::uint32_t in_thousandths(float force_N) const {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(1e3F * force_N / rated_N_))) &
           0xFFFF;
  }
  void target(float force_N) { ASSERT_EQ(bench_.write(0x6071, 0, in_thousandths(force_N), 2), 0U); }
  void offset(float force_N) { ASSERT_EQ(bench_.write(0x60B2, 0, in_thousandths(force_N), 2), 0U); }
  void mode(std::uint8_t wanted) {
    ASSERT_EQ(bench_.write(0x6060, 0, wanted, 1), 0U);
    ASSERT_EQ(bench_.read(0x6061, 0), wanted);
  }
  float current_A() const { return bench_.loop->motor.set_point_A; }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  std::uint32_t status() { return bench_.read(0x6041, 0) & 0x6F; }

  // Ticks one by one; the largest change of the current in one of them.
  float largest_step_A(int ticks) {
    float largest = 0.0F;
    for (int i = 0; i < ticks; ++i) {
      const float before = current_A();
      bench_.loop->step();
      largest = std::max(largest, std::abs(current_A() - before));
      if (i % 10 == 9) bench_.poll();
    }
    return largest;
  }

  Bench bench_;
  float per_newton_ = 0.0F;
  float rated_N_ = 0.0F;
  std::int32_t home_ = 0;
};

TEST_F(Torque, TheForceIsTargetAndOffset) {
  target(5.0F);
  bench_.enable(kTorque);
  EXPECT_EQ(bench_.read(0x6061, 0), kTorque);
  const float quantum_A = 1e-3F * rated_N_ * per_newton_;
  bench_.run_ms(2);
  EXPECT_NEAR(current_A(), 5.0F * per_newton_, quantum_A) << "from standstill it does not fade in";
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x1000, 0x1000U) << "the drive follows the command";
  offset(-2.0F);
  bench_.run_ms(1);
  EXPECT_NEAR(current_A(), 3.0F * per_newton_, quantum_A);
  target(-4.0F);
  bench_.run_ms(1);
  EXPECT_NEAR(current_A(), -6.0F * per_newton_, quantum_A);
  EXPECT_NEAR(static_cast<std::int16_t>(bench_.read(0x6074, 0)),
              static_cast<std::int16_t>(in_thousandths(-6.0F)), 1);
  EXPECT_EQ(bench_.read_real(0x2200, 2), 0.0F) << "no feedback";
  // 5 N are within pre-sliding: the axis gives way by some micrometres and stays.
  EXPECT_LT(std::abs(bench_.read_signed(0x6064, 0) - home_), 100);
}

// 2000h:25: where the axis gives way, the friction of the model there is added to what is asked for.
TEST_F(Torque, AShareOfTheFrictionIsAdded) {
  ASSERT_EQ(bench_.write_real(0x2000, 0x25, 0.5F), 0U);
  ASSERT_EQ(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
  target(5.0F);
  bench_.enable(kTorque);
  bench_.loop->pushed_N = 5.0;
  bench_.run_ms(50);
  const float friction_N = bench_.read_real(0x2200, 6);
  EXPECT_GT(friction_N, 1.0F);
  const float quantum_A = 1e-3F * rated_N_ * per_newton_;
  EXPECT_NEAR(current_A(), (5.0F + 0.5F * friction_N) * per_newton_, quantum_A);
  // It is within the velocity limit as the target is.
  EXPECT_EQ(bench_.write_real(0x2000, 0x25, 1.5F), 0x06090031U);
}

TEST_F(Torque, LimitsOfTheCurrentApply) {
  ASSERT_EQ(bench_.write_real(0x2000, 9, 0.5F), 0U);
  ASSERT_EQ(bench_.write_real(0x2000, 10, 100.0F), 0U);
  ASSERT_EQ(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
  bench_.run_ms(2);
  ASSERT_EQ(bench_.write(0x6071, 0, 1000, 2), 0U);
  bench_.enable(kTorque);
  EXPECT_LE(largest_step_A(200), 100.0F * 1e-4F * 1.001F);
  EXPECT_EQ(current_A(), 0.5F);
  EXPECT_EQ(bench_.read(0x2200, 10) & 1U, 1U);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x0800, 0x0800U) << "internal limit";
}

TEST_F(Torque, TheOffsetCountsInPositionModesToo) {
  bench_.enable(kCyclicPosition);
  bench_.run_ms(300);
  const float before_A = current_A();
  offset(8.0F);
  // At once a step of the current; the integral takes it back, since the axis shall stand where it is.
  bench_.run_ms(1);
  EXPECT_NEAR(current_A() - before_A, 8.0F * per_newton_, 0.3F * 8.0F * per_newton_);
  bench_.run_ms(1500);
  // All but what the hysteresis keeps of the micrometres that the axis has gone to and fro.
  EXPECT_NEAR(current_A(), before_A, 0.5F * 8.0F * per_newton_);
  EXPECT_NEAR(bench_.read_signed(0x6064, 0), home_, 5);
}

// Under way at 0.25 m/s, to torque mode and back: the current goes over without a jump, the axis comes to
// rest under control.
TEST_F(Torque, ChangesOfModeInMotionAreWithoutAJump) {
  bench_.enable(kPosition);
  ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(home_ + 150000), 4), 0U);
  ASSERT_EQ(bench_.write(0x6040, 0, 0x1F, 2), 0U);
  bench_.run_ms(250);
  ASSERT_GT(velocity(), 0.08);
  const float in_motion_A = largest_step_A(100);
  target(25.0F);
  mode(kTorque);
  // 25 N and what is wanted now are an ampere apart; fading takes 20 ms.
  EXPECT_LT(largest_step_A(400), in_motion_A + 0.05F);
  EXPECT_NEAR(current_A(), 25.0F * per_newton_, 2e-3F * rated_N_ * per_newton_);
  ASSERT_GT(velocity(), 0.05);
  const double before = velocity();
  mode(kPosition);
  // The stop begins with 15 m/s2 and 35 kg: 9 A, which at once would be cut to 2 A a tick. They fade in, and
  // meanwhile the feedback asks for what is missing.
  EXPECT_LT(largest_step_A(30), 0.5F);
  EXPECT_GT(velocity(), 0.5 * before) << "from the velocity that the axis has";
  bench_.run_ms(300);
  EXPECT_EQ(status(), 0x27U);
  EXPECT_NEAR(velocity(), 0.0, 1e-3);
  const std::int32_t stands = bench_.read_signed(0x6064, 0);
  bench_.run_ms(200);
  EXPECT_NEAR(bench_.read_signed(0x6064, 0), stands, 3);
  for (std::uint8_t fault = 1; fault < 12; ++fault) EXPECT_EQ(bench_.read(0x2212, fault), 0U) << int{fault};
}

TEST_F(Torque, QuickStopBrakesFromTheVelocityOfTheAxis) {
  target(60.0F);
  bench_.enable(kTorque);
  bench_.run_ms(150);
  const double begin = velocity();
  ASSERT_GT(begin, 0.1);
  const double from = bench_.loop->plant.position_m();
  ASSERT_EQ(bench_.write(0x6040, 0, 0x0B, 2), 0U);
  bench_.run_ms(1);
  EXPECT_EQ(status(), 0x07U);
  int milliseconds = 1;
  while (status() == 0x07U && milliseconds < 500) {
    bench_.run_ms(1);
    ++milliseconds;
  }
  EXPECT_EQ(status() & 0x4F, 0x40U);
  EXPECT_FALSE(bench_.loop->motor.enabled);
  EXPECT_NEAR(velocity(), 0.0, 0.02);
  // Half the velocity over 2 sqrt(v / j), as the deceleration limit is not reached; and what settling adds.
  const double way = bench_.loop->plant.position_m() - from;
  const AxisParameters& axis = bench_.loop->controller().parameters().axis;
  const auto jerk = static_cast<double>(axis.jerk_limit_mps3);
  ASSERT_LT(std::sqrt(begin * jerk), static_cast<double>(axis.quick_stop_mps2));
  EXPECT_GT(way, 0.8 * begin * std::sqrt(begin / jerk));
  EXPECT_LT(way, 1.3 * begin * std::sqrt(begin / jerk) + 1e-3);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

TEST_F(Torque, HaltBrakesAndGoesOnAfterwards) {
  target(60.0F);
  bench_.enable(kTorque);
  bench_.run_ms(100);
  ASSERT_GT(velocity(), 0.05);
  ASSERT_EQ(bench_.write(0x6040, 0, 0x10F, 2), 0U);
  bench_.run_ms(200);
  EXPECT_EQ(status(), 0x27U);
  EXPECT_NEAR(velocity(), 0.0, 1e-3);
  ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
  bench_.run_ms(100);
  EXPECT_GT(velocity(), 0.03);
}

// 605Eh: after a fault that leaves the position to be trusted the axis is braked (2) or let go (0).
TEST_F(Torque, FaultReactionIsAStopOrNone) {
  EXPECT_EQ(bench_.write(0x605E, 0, 3, 2), 0x06090031U);
  for (const std::uint32_t option : {2U, 0U}) {
    Bench bench;
    bench.configure();
    ASSERT_EQ(bench.write(0x605E, 0, option, 2), 0U);
    bench.enable(kPosition);
    ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home_ + 60000), 4), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
    bench.run_ms(150);
    ASSERT_TRUE(bench.loop->motor.enabled);
    bench.loop->clock.advance(600);  // a tick that comes late
    bench.loop->step();
    EXPECT_EQ(bench.loop->motor.enabled, option == 2) << option;
    EXPECT_EQ(bench.loop->controller().state().faults().latched(), Fault::kTickOverrun);
    bench.run_ms(500);
    EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x08U);
  }
}

TEST_F(Torque, ActualTorqueIsWhatTheSensorSays) {
  target(10.0F);
  bench_.enable(kTorque);
  bench_.loop->motor.measurement_follows = false;
  bench_.loop->motor.measurement.current_A = 7.0F * per_newton_;
  bench_.run_ms(1);
  EXPECT_NEAR(static_cast<std::int16_t>(bench_.read(0x6077, 0)),
              static_cast<std::int16_t>(in_thousandths(7.0F)), 1);
  EXPECT_NEAR(static_cast<std::int16_t>(bench_.read(0x6074, 0)),
              static_cast<std::int16_t>(in_thousandths(10.0F)), 1);
}

}  // namespace
}  // namespace slipstack::can
