// SPDX-License-Identifier: Apache-2.0
// I2t of motor and amplifier: against its closed solution, on an axis that is worked too hard, and as a
// fault.
#include "firmware/control/current/thermal_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/loop/axis_loop.h"

namespace slipstack::loop {
namespace {

TEST(ThermalLimit, FollowsItsExponential) {
  for (const double current_A : {0.0, 3.0, 5.0, 9.0}) {
    for (const double step_s : {1e-3, 5e-3}) {
      ThermalLoad load;
      double t = 0.0;
      for (; t < 7.0; t += step_s) {
        load.step(static_cast<float>(step_s), static_cast<float>(current_A), 5.0F, 10.0F);
      }
      const double end = current_A * current_A / 25.0;
      EXPECT_NEAR(load.load(), end + (0.9 - end) * std::exp(-t / 10.0), 2e-3) << current_A;
    }
  }
}

TEST(ThermalLimit, FallsFromPeakToRatedWithoutAStep) {
  ThermalLoad load;
  float before = load.limit_A(10.0F, 4.0F);
  EXPECT_EQ(before, 10.0F) << "all of the peak at 90 %";
  for (int i = 0; i < 100'000; ++i) {
    const float limit = load.limit_A(10.0F, 4.0F);
    ASSERT_LE(std::abs(limit - before), 0.04F);
    before = limit;
    load.step(1e-3F, limit, 4.0F, 10.0F);  // always as much as is allowed
    ASSERT_LE(load.load(), 1.001F);
  }
  EXPECT_NEAR(before, 4.0F, 0.1F);
  load.step(1e-3F, std::nanf(""), 4.0F, 10.0F);
  EXPECT_TRUE(std::isfinite(load.load()));
  EXPECT_EQ(load.limit_A(10.0F, 0.0F), 10.0F) << "no rating, no limit";
  EXPECT_EQ(load.limit_A(3.0F, 4.0F), 3.0F);
}

// Pressed against a stop with more than the rated current: the current sinks to it, or the drive stops.
class Pressed {
 public:
  explicit Pressed(bool fault) : bench_(sim::draw_bench(sim::Setup::kPickAndPlace, 7)), loop_(bench_.axis) {
    AxisParameters parameters = pick_and_place_parameters(bench_.axis);
    parameters.motor_rated_A = 1.0F;
    parameters.motor_thermal_s = 2.0F;
    parameters.overload_is_fault = fault;
    parameters.stall_s = 10.0F;
    parameters.unseen_motion_m = 0.0F;
    EXPECT_EQ(loop_.controller().configure(parameters, identified_model(bench_.axis, 0.0, 0.0)),
              ParameterStatus::kOk);
    place_ = static_cast<std::int32_t>(loop_.encoder.counts(loop_.plant.position_m()));
    run(0.01);
    EXPECT_TRUE(loop_.enable());
    controller().command_all(0x0FU | kTorqueMode);
    run(4.0);  // cools down
    controller().set_torque(4.0F * parameters.motor_constant_N_per_A, 0.0F);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1e4); ++i) {
      loop_.board_encoder.next.counts = place_ + i % 2;  // stands, and trembles
      loop_.tick.run();
      loop_.clock.advance(1000);
      if (i % 10 == 0) {
        controller().poll();
        loop_.tick.main_loop_ran();
      }
      largest_A = std::max(largest_A, loop_.motor.set_point_A);
    }
  }
  Controller& controller() { return loop_.controller(); }
  float current_A() const { return loop_.motor.set_point_A; }
  float largest_A = 0.0F;

 private:
  sim::Bench bench_;
  AxisLoop loop_;
  std::int32_t place_ = 0;
};

TEST(ThermalLimit, TakesTheCurrentBackToTheRatedOne) {
  Pressed axis(false);
  EXPECT_FALSE(axis.controller().thermal().reduces());
  axis.run(0.09);  // 16 times the heat: 0.1 s from 12 % to 90 %
  EXPECT_NEAR(axis.largest_A, 4.0F, 0.01F) << "the peak is there at first";
  axis.run(10.0);
  EXPECT_NEAR(axis.current_A(), 1.0F, 0.05F);
  EXPECT_TRUE(axis.controller().thermal().reduces());
  EXPECT_EQ(axis.controller().state().state(), DriveState::kOperationEnabled);
  axis.controller().set_torque(0.0F, 0.0F);
  axis.run(3.0);
  EXPECT_FALSE(axis.controller().thermal().reduces()) << "cooled down";
}

TEST(ThermalLimit, IsAFaultWhereThatIsWanted) {
  Pressed axis(true);
  axis.run(5.0);
  EXPECT_EQ(axis.controller().state().faults().latched(), Fault::kOverload);
  EXPECT_EQ(error_code(Fault::kOverload), 0x2350);
  EXPECT_NE(axis.controller().state().state(), DriveState::kOperationEnabled);
}

}  // namespace
}  // namespace slipstack::loop
