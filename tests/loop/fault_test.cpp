// SPDX-License-Identifier: Apache-2.0
// Each fault injected into a moving axis: latched, counted, and ended with zero current or a controlled stop.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "tests/loop/axis_loop.h"

namespace slipstack::loop {
namespace {

class Faults : public ::testing::Test {
 protected:
  Faults()
      : bench_(sim::draw_bench(sim::Setup::kPickAndPlace, 7)),
        loop_(std::make_unique<AxisLoop>(bench_.axis)) {
    parameters_ = pick_and_place_parameters(bench_.axis);
    model_ = identified_model(bench_.axis, 0.0, 0.0);
    EXPECT_EQ(loop_->controller().configure(parameters_, model_), ParameterStatus::kOk);
    loop_->run(0.01);
    EXPECT_TRUE(loop_->enable());
    home_ = loop_->controller().reference().counts();
    EXPECT_EQ(loop_->controller().move_to(home_ + 100000), PlanStatus::kOk);
    loop_->run(0.1);
    EXPECT_TRUE(loop_->motor.enabled);
    EXPECT_GT(loop_->plant.velocity_mps(), 0.2);
  }

  // Steps with what the sensors say changed by `disturb`, until the state is Fault or the time is over.
  // Returns the ticks that took; the largest current meanwhile goes to largest_A_.
  int inject(const std::function<void(AxisLoop&, std::int32_t counts)>& disturb, int most_ticks) {
    for (int tick = 1; tick <= most_ticks; ++tick) {
      const auto counts = static_cast<std::int32_t>(loop_->encoder.counts(loop_->plant.position_m()));
      loop_->board_encoder.next.counts = counts;
      disturb(*loop_, counts);
      loop_->tick.run();
      if (loop_->motor.enabled) largest_A_ = std::max(largest_A_, std::abs(loop_->motor.set_point_A));
      loop_->plant.step(loop_->motor.enabled ? static_cast<double>(loop_->motor.set_point_A) : 0.0, kTick_s);
      loop_->clock.advance(1000);
      if (state() == DriveState::kFault) return tick;
    }
    return most_ticks + 1;
  }

  DriveState state() { return loop_->controller().state().state(); }
  const FaultRecord& record() { return loop_->controller().state().faults(); }

  void expect_dead(Fault fault) {
    EXPECT_EQ(state(), DriveState::kFault);
    EXPECT_EQ(record().latched(), fault);
    EXPECT_EQ(record().count(fault), 1);
    EXPECT_FALSE(loop_->motor.enabled);
    EXPECT_EQ(loop_->motor.set_point_A, 0.0F);
    // It stays so, whatever is commanded short of a reset.
    loop_->board_encoder.next.valid = true;
    loop_->motor.measurement = {};
    loop_->motor.measurement_follows = true;
    loop_->controller().command(0x0F);
    loop_->run(0.5);
    EXPECT_EQ(state(), DriveState::kFault);
    EXPECT_FALSE(loop_->motor.enabled);
    loop_->controller().command(0x80);
    loop_->run(0.001);
    EXPECT_EQ(state(), DriveState::kSwitchOnDisabled);
    EXPECT_EQ(record().latched(), Fault::kNone);
    EXPECT_EQ(record().count(fault), 1);
    EXPECT_TRUE(loop_->enable());
  }

  sim::Bench bench_;
  std::unique_ptr<AxisLoop> loop_;
  AxisParameters parameters_;
  ModelParameters model_;
  std::int32_t home_ = 0;
  float largest_A_ = 0.0F;
};

TEST_F(Faults, EncoderLoss) {
  EXPECT_EQ(inject([](AxisLoop& loop, std::int32_t) { loop.board_encoder.next.valid = false; }, 5), 1);
  expect_dead(Fault::kEncoderLoss);
}

TEST_F(Faults, EncoderJumpsByAMillionCounts) {
  EXPECT_EQ(
      inject([](AxisLoop& loop, std::int32_t counts) { loop.board_encoder.next.counts = counts + 1000000; },
             5),
      1);
  EXPECT_EQ(largest_A_, 0.0F);
  EXPECT_EQ(record().latched(), Fault::kEncoderJump);
  EXPECT_FALSE(loop_->motor.enabled);
}

// No force stops 0.3 m/s, or turns it round, within a tick: the encoder is not to be braked with.
TEST_F(Faults, EncoderFreezes) {
  const std::int32_t frozen = loop_->board_encoder.next.counts;
  EXPECT_LE(inject([frozen](AxisLoop& loop, std::int32_t) { loop.board_encoder.next.counts = frozen; }, 200),
            2);
  expect_dead(Fault::kEncoderJump);
}

TEST_F(Faults, EncoderRunsBackwards) {
  const std::int32_t turned = loop_->board_encoder.next.counts;
  const double before_mps = loop_->plant.velocity_mps();
  const int ticks = inject(
      [turned](AxisLoop& loop, std::int32_t counts) { loop.board_encoder.next.counts = 2 * turned - counts; },
      200);
  EXPECT_LE(ticks, 2);
  EXPECT_EQ(record().latched(), Fault::kEncoderJump);
  EXPECT_FALSE(loop_->motor.enabled);
  EXPECT_LT(loop_->plant.velocity_mps(), before_mps + 1e-3);
}

// Too slow for that: the axis is braked from what the encoder says; when it still does not follow, released.
TEST_F(Faults, ASlowEncoderThatRunsBackwardsIsNotTrustedTwice) {
  loop_->run(1.0);
  const auto at = static_cast<std::int32_t>(loop_->board_encoder.next.counts);
  ASSERT_EQ(
      loop_->controller().move_to(
          at + 100000, {.velocity = 5.0F, .acceleration = 0.05F, .deceleration = 0.05F, .jerk = 0.0005F}),
      PlanStatus::kOk);
  loop_->run(0.1);
  ASSERT_NEAR(loop_->plant.velocity_mps(), 0.05, 0.01);
  const std::int32_t turned = loop_->board_encoder.next.counts;
  const int ticks = inject(
      [turned](AxisLoop& loop, std::int32_t counts) { loop.board_encoder.next.counts = 2 * turned - counts; },
      2000);
  EXPECT_LT(ticks, 500);
  EXPECT_EQ(record().latched(), Fault::kFollowingError);
  EXPECT_FALSE(loop_->motor.enabled);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.35) << "10 A may push for some ms, no longer";
}

// A push that the current cannot hold against: the encoder is right, so the axis is braked from where it is.
TEST_F(Faults, FollowingErrorBrakesFromWhereTheAxisIs) {
  double largest_m = 0.0;
  double began_m = 0.0;
  for (int tick = 0; tick < 3000 && state() != DriveState::kFault; ++tick) {
    loop_->board_encoder.next.counts =
        static_cast<std::int32_t>(loop_->encoder.counts(loop_->plant.position_m()));
    const bool before = state() == DriveState::kFaultReactionActive;
    loop_->tick.run();
    if (!before && state() == DriveState::kFaultReactionActive) began_m = loop_->plant.position_m();
    if (state() == DriveState::kFaultReactionActive) {
      EXPECT_TRUE(loop_->motor.enabled);
      largest_m = std::max(largest_m, std::abs(loop_->true_error_m()));
    }
    const bool pushed = began_m == 0.0;
    loop_->plant.step(loop_->motor.enabled ? static_cast<double>(loop_->motor.set_point_A) : 0.0, kTick_s,
                      pushed ? 900.0 : 0.0);
    loop_->clock.advance(1000);
  }
  EXPECT_EQ(record().latched(), Fault::kFollowingError);
  EXPECT_EQ(record().count(Fault::kFollowingError), 1);
  EXPECT_GT(began_m, 0.0);
  EXPECT_LT(largest_m, 0.5e-3) << "follows the new reference";
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01) << "at rest when the current goes";
  // Some 0.6 m/s by now, v sqrt(v / j) at 200 m/s3.
  EXPECT_LT(loop_->plant.position_m() - began_m, 0.06);
  expect_dead(Fault::kFollowingError);
}

// The same push for ever: it cannot be braked, and that is noticed.
TEST_F(Faults, WhatDoesNotBrakeIsReleased) {
  for (int tick = 0; tick < 3000 && state() != DriveState::kFault; ++tick) {
    loop_->board_encoder.next.counts =
        static_cast<std::int32_t>(loop_->encoder.counts(loop_->plant.position_m()));
    loop_->tick.run();
    loop_->plant.step(0.0, kTick_s, state() == DriveState::kFault ? 0.0 : 400.0);
    loop_->clock.advance(1000);
  }
  EXPECT_EQ(state(), DriveState::kFault);
  EXPECT_EQ(record().latched(), Fault::kFollowingError);
  EXPECT_FALSE(loop_->motor.enabled);
}

TEST_F(Faults, BlockedAxisIsAStall) {
  parameters_.following_error_m = 0.5F;
  parameters_.stall_current_A = 1.0F;
  parameters_.unseen_motion_m = 0.0F;  // unseen_motion_test.cpp
  loop_->run(1.0);
  ASSERT_EQ(loop_->controller().configure(parameters_, model_), ParameterStatus::kOk);
  loop_->run(0.01);
  ASSERT_EQ(loop_->controller().move_to(home_), PlanStatus::kOk);
  const std::int32_t stuck = loop_->board_encoder.next.counts;
  inject([stuck](AxisLoop& loop, std::int32_t) { loop.board_encoder.next.counts = stuck; }, 2000);
  EXPECT_EQ(record().latched(), Fault::kStall);
  EXPECT_FALSE(loop_->motor.enabled);
}

// Beyond the limit for a moment: braked by the current that is right again.
TEST_F(Faults, OverCurrentThatPassesBrakes) {
  int tick = 0;
  const int ticks = inject(
      [&tick](AxisLoop& loop, std::int32_t) {
        loop.motor.measurement_follows = ++tick > 10;
        loop.motor.measurement.current_A = tick > 10 ? loop.motor.set_point_A : 15.5F;
      },
      2000);
  EXPECT_GT(ticks, 700);
  EXPECT_LT(ticks, 820);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01);
  expect_dead(Fault::kOverCurrent);
}

TEST_F(Faults, OverCurrentThatStaysReleases) {
  EXPECT_EQ(inject(
                [](AxisLoop& loop, std::int32_t) {
                  loop.motor.measurement_follows = false;
                  loop.motor.measurement.current_A = 15.5F;
                },
                100),
            21);  // 2 ms and the tick that sees it
  expect_dead(Fault::kOverCurrent);
}

// Without the measurement the amplifier may well be right: the axis is braked, and its encoder says whether.
TEST_F(Faults, CurrentSensorMissingBrakes) {
  const int ticks = inject(
      [](AxisLoop& loop, std::int32_t) {
        loop.motor.measurement_follows = false;
        loop.motor.measurement.valid = false;
      },
      2000);
  EXPECT_GT(ticks, 700);
  EXPECT_LT(ticks, 840);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01);
  expect_dead(Fault::kCurrentSensor);
}

TEST_F(Faults, CurrentSensorImplausibleBrakes) {
  inject(
      [](AxisLoop& loop, std::int32_t) {
        loop.motor.measurement_follows = false;
        loop.motor.measurement.current_A = loop.motor.set_point_A + 2.5F;
      },
      2000);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01);
  expect_dead(Fault::kCurrentSensor);
}

TEST_F(Faults, ACurrentThatIsNotANumberIsImplausible) {
  inject(
      [](AxisLoop& loop, std::int32_t) {
        loop.motor.measurement_follows = false;
        loop.motor.measurement.current_A = std::numeric_limits<float>::quiet_NaN();
      },
      2000);
  expect_dead(Fault::kCurrentSensor);
}

TEST_F(Faults, AForceThatIsNotFiniteNeverReachesTheMotor) {
  // Within its bounds each, but their product overflows.
  parameters_.velocity_gain_N_s_per_m = 1e6F;
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model_);
  auto& ripple = std::get<EffectParameters<MotorConstantRipple<float>, float>>(model_);
  auto& drift = std::get<EffectParameters<Drift<float>, float>>(model_);
  auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model_);
  inertia.gains[0] = 1e5F;
  ripple.enabled = true;
  ripple.gains.fill(0.9F);
  ripple.shapes = {0.024F};
  drift.enabled = true;
  drift.gains = {20.0F};
  drift.shapes = {1.0F, 1.0F};
  hysteresis.gains.fill(1e12F);
  hysteresis.shapes.fill(1.0F);
  if (loop_->controller().configure(parameters_, model_) == ParameterStatus::kOk) {
    inject([](AxisLoop&, std::int32_t) {}, 3000);
    EXPECT_TRUE(std::isfinite(loop_->motor.set_point_A));
    EXPECT_LE(largest_A_, parameters_.current_limit_A);
  }
  loop_->controller().inject(Fault::kNotFinite);
  inject([](AxisLoop&, std::int32_t) {}, 2);
  EXPECT_EQ(state(), DriveState::kFault);
  EXPECT_FALSE(loop_->motor.enabled);
}

TEST_F(Faults, TickOverrunBrakesUnderControl) {
  loop_->clock.advance(600);
  const int ticks = inject([](AxisLoop&, std::int32_t) {}, 2000);
  // From 0.3 m/s at 200 m/s3, 2 sqrt(v / j): 77 ms; the axis stands when the current goes.
  EXPECT_GT(ticks, 700);
  EXPECT_LT(ticks, 820);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01);
  EXPECT_EQ(loop_->tick.timing().overruns, 1U);
  expect_dead(Fault::kTickOverrun);
}

TEST_F(Faults, RefusedParametersBrakeUnderControlAndChangeNothing) {
  AxisParameters wrong = parameters_;
  wrong.velocity_gain_N_s_per_m = std::numeric_limits<float>::quiet_NaN();
  const std::uint32_t hash = loop_->controller().parameters().hash;
  EXPECT_EQ(loop_->controller().configure(wrong, model_), ParameterStatus::kAxisOutOfBounds);
  const int ticks = inject([](AxisLoop&, std::int32_t) {}, 2000);
  EXPECT_GT(ticks, 700);
  EXPECT_LT(ticks, 820);
  EXPECT_EQ(loop_->controller().parameters().hash, hash);
  EXPECT_EQ(loop_->controller().parameters().axis.velocity_gain_N_s_per_m,
            parameters_.velocity_gain_N_s_per_m);
  expect_dead(Fault::kParameter);
}

TEST_F(Faults, QuickStopEndsDisabledAndAtRest) {
  loop_->controller().command(0x0B);
  loop_->run(0.01);
  EXPECT_EQ(state(), DriveState::kQuickStopActive);
  loop_->run(0.08);
  EXPECT_EQ(state(), DriveState::kSwitchOnDisabled);
  EXPECT_FALSE(loop_->motor.enabled);
  EXPECT_LT(std::abs(loop_->plant.velocity_mps()), 0.01);
  EXPECT_EQ(record().latched(), Fault::kNone);
}

// As long as the axis is braked, and no longer, the limits say so; beside what the current says.
TEST_F(Faults, TheLimitsSayThatAStopBrakes) {
  const auto brakes = [this] { return (loop_->controller().output().limits & kLimitReference) != 0; };
  EXPECT_FALSE(brakes());
  loop_->controller().command(0x0B);
  loop_->run(0.001);
  while (state() == DriveState::kQuickStopActive && std::abs(loop_->plant.velocity_mps()) > 0.01) {
    EXPECT_TRUE(brakes());
    loop_->step();
  }
  loop_->run(0.3);
  EXPECT_EQ(state(), DriveState::kSwitchOnDisabled);
  EXPECT_FALSE(brakes());
}

TEST(Watchdog, AResetByItIsAFaultUntilAcknowledged) {
  host::HostEncoder encoder;
  host::HostMotorCurrent motor;
  host::HostClock clock;
  host::HostWatchdog watchdog;
  host::HostDigitalIo io;
  watchdog.reset_by_watchdog = true;
  const auto tick =
      std::make_unique<Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog,
                            host::HostDigitalIo>>(encoder, motor, clock, watchdog, io);
  tick->run();
  EXPECT_EQ(tick->controller().state().state(), DriveState::kFault);
  EXPECT_EQ(tick->controller().state().faults().latched(), Fault::kWatchdog);
  EXPECT_EQ(watchdog.refreshed, 1U);
}

// A main loop that stands still for more than half a second lets the watchdog reset the board; one that
// stores parameters, 50 ms, does not.
TEST(Watchdog, IsRefreshedOnlyWhileTheMainLoopAdvances) {
  host::HostEncoder encoder;
  host::HostMotorCurrent motor;
  host::HostClock clock;
  clock.rate_Hz = 10'000'000;
  host::HostWatchdog watchdog;
  host::HostDigitalIo io;
  const auto tick =
      std::make_unique<Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog,
                            host::HostDigitalIo>>(encoder, motor, clock, watchdog, io);
  tick->set_period(1000);
  const auto run = [&](std::uint32_t ticks) {
    const std::uint32_t before = watchdog.refreshed;
    for (std::uint32_t i = 0; i < ticks; ++i) {
      clock.advance(1000);
      tick->run();
    }
    return watchdog.refreshed - before;
  };
  tick->main_loop_ran();
  EXPECT_EQ(run(500), 500U);
  tick->main_loop_ran();
  EXPECT_EQ(run(10000), 5000U);
  tick->main_loop_ran();
  EXPECT_EQ(run(100), 100U);
}

// The force of a change of mode fades over the swap time. Where the axis is braked anew before that is over,
// what is left of it does not push the braking axis: the current is what it is with any swap time.
TEST(FaultReaction, AnAxisThatIsBrakedAnewIsNotPushedByAFade) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis;
  // The current of the tick after a change from torque to position in motion.
  const auto current_A = [&axis](float swap_time_s, Fault fault) {
    AxisLoop loop(axis);
    AxisParameters parameters = pick_and_place_parameters(axis);
    parameters.swap_time_s = swap_time_s;
    EXPECT_EQ(loop.controller().configure(parameters, identified_model(axis, 0.02, 0.01)),
              ParameterStatus::kOk);
    loop.step();
    // Enabled in torque mode: nothing has faded before the change.
    for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
      loop.controller().command(Command{word | kTorqueMode, 60.0F, 0.0F});
      loop.step();
      loop.step();
    }
    for (int i = 0; i < 400; ++i) loop.step();
    EXPECT_GT(loop.plant.velocity_mps(), 0.01);
    loop.controller().command(Command{0x0FU, 0.0F, 0.0F});
    loop.step();
    if (fault != Fault::kNone) loop.controller().inject(fault);
    loop.step();
    EXPECT_EQ(loop.controller().state().faults().latched(), fault);
    EXPECT_TRUE(loop.controller().output().driving);
    return loop.controller().output().current_A;
  };
  EXPECT_NE(current_A(0.1F, Fault::kNone), current_A(1e-3F, Fault::kNone)) << "it fades";
  EXPECT_EQ(current_A(0.1F, Fault::kFollowingError), current_A(1e-3F, Fault::kFollowingError));
}

}  // namespace
}  // namespace slipstack::loop
