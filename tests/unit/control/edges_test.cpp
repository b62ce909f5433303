// SPDX-License-Identifier: Apache-2.0
// Edges of rules that the tests of the whole did not tell apart: each was a mutant that survived.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "firmware/control/bounds/motion_bounds.h"
#include "firmware/control/current/load_watch.h"
#include "firmware/control/current/thermal_limit.h"
#include "firmware/control/force/force_control.h"
#include "firmware/control/parameters/control_set.h"
#include "firmware/control/parameters/parameters.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/streams/cyclic_position.h"
#include "firmware/control/streams/set_point_periods.h"
#include "firmware/control/supervision/digital_io.h"
#include "firmware/control/supervision/direction_check.h"
#include "firmware/control/supervision/state_machine.h"

namespace slipstack {
namespace {

/// A state machine whose operation is enabled, of an axis that stands.
class EnabledMachine {
 public:
  explicit EnabledMachine(std::int32_t brake_apply) {
    times_.brake_apply = brake_apply;
    for (const std::uint32_t word : {0x00U, 0x06U, 0x07U, 0x0FU}) step(word);
  }
  DriveState step(std::uint32_t word) {
    machine_.step(
        word, Fault::kNone, true, [] { return true; }, times_);
    return machine_.state();
  }
  /// Ticks for which a quick stop is seen, the first one not counted.
  int quick_stop_ticks() {
    EXPECT_EQ(step(0x0B), DriveState::kQuickStopActive);
    int ticks = 0;
    while (step(0x0B) == DriveState::kQuickStopActive && ticks < 20) ++ticks;
    return ticks;
  }
  DriveState state() const { return machine_.state(); }

 private:
  StateMachine machine_;
  StopTimes times_{.quick_stop = 100, .slow_down = 100, .brake_release = 0, .brake_apply = 0};
};

// A quick stop of an axis that stands: its state is seen for a tick before it is left, with brake and
// without.
TEST(Edges, AStopOfAnAxisThatStandsTakesOneTickAndTheBrake) {
  for (const std::int32_t apply : {0, 3}) {
    EnabledMachine machine(apply);
    ASSERT_EQ(machine.state(), DriveState::kOperationEnabled);
    EXPECT_EQ(machine.quick_stop_ticks(), apply + 1);
    EXPECT_EQ(machine.state(), DriveState::kSwitchOnDisabled);
  }
}

// The stop time-out, where the user's ramp is longer: v / d at 1.5 times the velocity, and 2 d / j.
TEST(Edges, ALongRampHasItsTime) {
  AxisParameters axis;
  axis.velocity_limit_mps = 3.0F;
  UserBounds user;
  EXPECT_EQ(MotionBounds::of(axis, user).times.quick_stop, 10000);
  user.quick_stop_counts_per_s2 = 2.0e6F;  // 2 m/s2
  EXPECT_NEAR(MotionBounds::of(axis, user).times.quick_stop, 1e4 * (1.5 * 3.0 / 2.0 + 2.0 * 2.0 / 1500.0),
              2.0);
  EXPECT_EQ(MotionBounds::of(axis, user).times.slow_down, 10000);
  user.slow_down_counts_per_s3 = 1.0e7F;  // 10 m/s3
  EXPECT_NEAR(MotionBounds::of(axis, user).times.slow_down, 1e4 * (1.5 * 3.0 / 15.0 + 2.0 * 15.0 / 10.0),
              2.0);
}

// Displacement has as many binary places of a count as the largest slip distance leaves of 16 bits.
TEST(Edges, FineEncodersLoseBinaryPlacesOfTheDisplacement) {
  constexpr auto kLargest = static_cast<double>(PackedMaxwellSlip<kTargetElements>::kLargestSlipDistance);
  ModelParameters model{};
  auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  hysteresis.shapes[3] = 400e-6F;
  AxisParameters axis;
  for (const double resolution_m : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    axis.encoder_resolution_m = static_cast<float>(resolution_m);
    hysteresis.enabled = true;
    const int places = static_cast<int>(std::floor(std::log2(kLargest * resolution_m / 400e-6)));
    EXPECT_EQ(displacement_shift(axis, model), std::min(4, places)) << resolution_m;
    hysteresis.enabled = false;
    EXPECT_EQ(displacement_shift(axis, model), 4) << resolution_m;
  }
  hysteresis.enabled = true;
  axis.encoder_resolution_m = 1e-10F;
  hysteresis.shapes[3] = 1e3F;
  EXPECT_EQ(displacement_shift(axis, model), -16) << "and not for ever";
}

// Two in a row are bridged and counted; three end the stream, which is a gap.
TEST(Edges, BridgedSetPointsAreCountedOneByOne) {
  for (const std::uint32_t lost : {0U, 1U, 2U}) {
    CyclicPosition cyclic;
    StreamPath path;
    cyclic.set_period(20.0F, 1e-4F);
    path.set_limits(cyclic.path_limits({200.0F, 0.15F, 0.15F, 1.5e-3F}, {}, CyclicPosition::kRounding));
    cyclic.start();
    std::uint32_t tick = 0;
    for (std::uint32_t n = 0; n < 600; ++n) {
      const bool missing = n == 400 || (lost == 2 && n == 401);
      cyclic.sync(tick, lost == 0 || !missing, static_cast<std::int32_t>(10 * n), path,
                  [](std::uint32_t) { return Motion{}; });
      for (int i = 0; i < 20; ++i) static_cast<void>(cyclic.step(tick++));
    }
    EXPECT_EQ(cyclic.bridged(), lost);
    EXPECT_EQ(cyclic.gaps(), 0U);
    EXPECT_TRUE(cyclic.following());
  }
}

// After a lost set-point the parabola bends as the path does: the one after it is late, and told from a
// second loss.
TEST(Edges, PeriodsAreToldOnABentPathAfterALoss) {
  const auto path = [](std::uint32_t n) { return static_cast<std::int32_t>(20 * n * n); };
  SetPointPeriods periods;
  for (std::uint32_t n = 1; n <= 6; ++n) periods.place(n, path(n), 100000);
  EXPECT_EQ(periods.place(8, path(8), 100000).period, 8U);   // 7 was lost
  EXPECT_EQ(periods.place(10, path(9), 100000).period, 9U);  // late by a period
  EXPECT_EQ(periods.place(10, path(10), 100000).period, 10U);
  EXPECT_EQ(periods.place(12, path(12), 100000).period, 12U);  // 11 was lost
}

// A new stream has nothing to do with the set-points of the last one.
TEST(Edges, ANewStreamForgetsTheLast) {
  SetPointPeriods periods;
  for (std::uint32_t n = 1; n <= 6; ++n) periods.place(n, static_cast<std::int32_t>(1000 * n), 1000);
  periods.reset();
  const SetPointPeriods::Place first = periods.place(8, 90000, 1000);
  EXPECT_EQ(first.period, 8U);
  EXPECT_EQ(first.counts, 90000) << "and not as far as the axis may move from there";
}

// The model's delay in ticks, rounded.
TEST(Edges, TheLeadIsTheDelayInTicks) {
  ModelParameters model{};
  auto& delay = std::get<EffectParameters<TimeDelay<float>, float>>(model);
  delay.shapes = {1.26e-3F, 0.4e-3F};
  EXPECT_EQ(lead_ticks(model, 1e-4F), 0);
  delay.enabled = true;
  EXPECT_EQ(lead_ticks(model, 1e-4F), 17);
  delay.shapes = {0.0F, 0.0F};
  EXPECT_EQ(lead_ticks(model, 1e-4F), 0);
}

// Well is: ready and no fault, whatever is inverted, on any other terminal too.
TEST(Edges, TheAmplifierIsWellWhereItIsReadyAndHasNoFault) {
  for (std::uint32_t inverted = 0; inverted < 8; ++inverted) {
    IoParameters parameters;
    parameters.amplifier_ready = 1;
    parameters.amplifier_fault = 2;
    parameters.inverted_inputs = static_cast<std::uint16_t>(inverted);
    const IoMasks io = IoMasks::of(parameters);
    for (std::uint32_t levels = 0; levels < 8; ++levels) {
      const DigitalInputs inputs(levels);
      EXPECT_EQ(inputs.amplifier_well(io), inputs.amplifier_ready(io) && !inputs.amplifier_fault(io));
      EXPECT_EQ(inputs.amplifier_well(io), ((levels ^ inverted) & 3U) == 1U);
    }
  }
}

// The brake closes in full, whatever a stop that was broken off had done of it.
TEST(Edges, AMoreUrgentStopClosesTheBrakeInFull) {
  constexpr std::int32_t kApply = 5;
  for (const int broken_off : {1, 3, 4}) {
    EnabledMachine machine(kApply);
    // Disable operation along the ramp, and a quick stop while the brake closes.
    for (int i = 0; i < 1 + broken_off; ++i)
      ASSERT_EQ(machine.step(0x07U | kBrakeOnDisable), DriveState::kOperationEnabled);
    EXPECT_EQ(machine.quick_stop_ticks(), kApply + 1) << broken_off;
  }
}

// What is asked for in one direction is asked for in the other: counts of the same size, to the count.
TEST(Edges, TheDirectionCheckIsTheSameBothWays) {
  const DirectionCheck::Settings settings{.wanted = true,
                                          .stand_ticks = 3,
                                          .distance_counts = 10,
                                          .largest_N = 4.0F,
                                          .step_N = 1.0F,
                                          .hold_ticks = 2};
  for (const std::int32_t far : {9, 10, 11}) {
    std::array<int, 2> ticks{};
    for (const std::size_t way : {0U, 1U}) {
      const std::int32_t sign = way == 0 ? 1 : -1;
      DirectionCheck check;
      check.begin(settings);
      // Moved once, after two ticks: by less than the distance it stands, else the time begins anew.
      while (!check.pushing() && ticks[way] < 50) {
        ++ticks[way];
        static_cast<void>(check.step(settings, 0, ticks[way] > 2 ? sign * far : 0));
      }
      EXPECT_EQ(ticks[way] > 5, far >= 10) << far << ' ' << way << ' ' << ticks[way];
      // Pushed forwards: along the force it is right, against it reversed, from the distance on.
      const std::int32_t from = sign * far;
      DirectionCheck other = check;
      EXPECT_EQ(check.step(settings, 0, from + far),
                far >= 10 ? DirectionCheck::Verdict::kRight : DirectionCheck::Verdict::kNone);
      EXPECT_EQ(other.step(settings, 0, from - far),
                far >= 10 ? DirectionCheck::Verdict::kReversed : DirectionCheck::Verdict::kNone);
    }
    EXPECT_EQ(ticks[0], ticks[1]) << far;
  }
}

// Steps of the hysteresis over a count and over a metre are the same scale, fine encoders and coarse ones.
TEST(Edges, StepsOfTheHysteresisHaveOneScale) {
  ModelParameters model{};
  std::get<EffectParameters<Inertia<float>, float>>(model) = {{10.0F}, {}, true};
  for (const float resolution_m : {1e-5F, 1e-6F, 1e-8F}) {
    AxisParameters axis;
    axis.encoder_resolution_m = resolution_m;
    ControlSet set;
    ASSERT_EQ(set.prepare(axis, model, UserBounds{}), ParameterStatus::kOk) << resolution_m;
    ASSERT_GT(set.scales.steps_per_count, 0.0F);
    EXPECT_NEAR(set.scales.steps_per_m * resolution_m, set.scales.steps_per_count,
                1e-6F * set.scales.steps_per_count);
    EXPECT_EQ(FeedForward::displacement(set.scales, 1) - FeedForward::displacement(set.scales, 0),
              static_cast<std::int32_t>(set.scales.steps_per_count));
  }
}

// A load that is spent is a fault in the sample in which it is, and never again while it lasts.
TEST(Edges, ALoadThatIsSpentIsAFaultOnce) {
  const auto set = std::make_unique<ControlSet>();
  set->valid = true;
  set->axis.motor_rated_A = 2.0F;
  set->axis.motor_thermal_s = 1.0F;
  set->axis.current_limit_A = 10.0F;
  set->axis.overload_is_fault = true;
  constexpr std::uint32_t kSample_ticks = 100;
  LoadWatch watch;
  std::uint32_t tick = 0;
  int faults = 0;
  for (int sample = 0; sample < 1000; ++sample) {
    const bool before = watch.thermal().spent();
    const bool fault = watch.step(*set, tick += kSample_ticks, true, 4.0F);
    EXPECT_EQ(fault, watch.thermal().spent() && !before) << sample;
    faults += fault ? 1 : 0;
  }
  EXPECT_EQ(faults, 1);
  for (int sample = 0; sample < 1000; ++sample)
    EXPECT_FALSE(watch.step(*set, tick += kSample_ticks, false, 0.0F)) << "it cools";
  ASSERT_FALSE(watch.thermal().spent());
  for (int sample = 0; sample < 1000; ++sample)
    faults += watch.step(*set, tick += kSample_ticks, true, 4.0F) ? 1 : 0;
  EXPECT_EQ(faults, 2) << "and is spent again";
}

// A queue that ends in motion is braked, whether the velocity changes at its end or not.
TEST(Edges, AQueueThatRunsDryIsBraked) {
  const BrakingLimits braking = braking_limits(0.2F, 0.02F);
  for (const float velocity : {-3.0F, 3.0F}) {
    for (const float acceleration : {-0.01F, 0.0F, 0.01F}) {
      ReferenceGenerator reference;
      reference.hold(0);
      ASSERT_TRUE(reference.push(
          {.ticks = 5, .velocity = to_fixed(velocity), .acceleration = to_fixed(acceleration)}));
      int ticks = 0;
      while ((ticks < 6 || !reference.standing()) && ticks < 500) {
        static_cast<void>(reference.next(braking));
        ++ticks;
      }
      EXPECT_TRUE(reference.standing()) << velocity << ' ' << acceleration;
      EXPECT_EQ(reference.underruns(), 1U);
    }
  }
}

// What was queued when the reference is held somewhere else is forgotten at once: the places are free.
TEST(Edges, AReferenceThatIsHeldHasAnEmptyQueue) {
  ReferenceGenerator reference;
  reference.hold(0);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(reference.push({.ticks = 5, .velocity = to_fixed(1.0F)}));
  EXPECT_FALSE(reference.idle());
  reference.hold(70);
  EXPECT_EQ(reference.free(), SegmentQueue::kCapacity);
  EXPECT_TRUE(reference.idle());
  for (int i = 0; i < 10; ++i) EXPECT_EQ(reference.next(braking_limits(0.2F, 0.02F)).counts, 70);
}

// An axis that the reference is taken to moves as its estimate says, to a count of the last step.
TEST(Edges, AReferenceBeginsAnewWithTheEstimateWithinACountOfTheLastStep) {
  AxisParameters axis;
  ModelParameters model{};
  std::get<EffectParameters<Inertia<float>, float>>(model) = {{10.0F}, {}, true};
  const auto set = std::make_unique<ControlSet>();
  ASSERT_EQ(set->prepare(axis, model, UserBounds{}), ParameterStatus::kOk);
  for (const std::int32_t step : {-30, 0, 25}) {
    for (const float estimated : {-100.0F, -1.5F, -0.9F, 0.0F, 0.7F, 1.2F, 40.0F}) {
      ForceControl force;
      force.start(*set, 0);
      // An estimate of so many counts per tick beside the step.
      ControlOutput out;
      TickHistory history;
      const MotionBounds bounds = MotionBounds::of(axis, {});
      const Command command;
      const float speed = static_cast<float>(step) + estimated;
      std::int32_t counts = 0;
      for (std::uint32_t tick = 0; tick < 400; ++tick) {
        counts = static_cast<std::int32_t>(std::floor(speed * static_cast<float>(tick)));
        force.step_off(
            {*set, bounds, command, history, history.entry(tick), out, tick, counts, 10.0F, false, false});
      }
      const float velocity = force.begin_anew(*set, step);
      EXPECT_NEAR(velocity,
                  std::clamp(speed, static_cast<float>(step) - 1.0F, static_cast<float>(step) + 1.0F), 0.05F)
          << step << ' ' << estimated;
      EXPECT_NEAR(force.estimate().velocity_mps(), velocity * set->mps_per_count, 1e-6F);
    }
  }
}

// At an end an axis is let go by a force that points away from there, and by none.
TEST(Edges, AForceAwayFromTheEndAndNoForceLetTheAxisGo) {
  const PositionRange range{-1000, 1000};
  const StoppingDistanceBound stopping = StoppingDistanceBound::of(0.1F, 1e-3F);
  for (const float sign : {-1.0F, 1.0F}) {
    TorqueBounds bounds;
    EXPECT_FALSE(bounds.holds());
    bounds.look_ahead(range, stopping, {static_cast<std::int32_t>(1000.0F * sign), 0.0F, 0.0F, 5.0F * sign});
    ASSERT_TRUE(bounds.holds());
    EXPECT_FALSE(bounds.pulled_inwards(3.0F * sign));
    EXPECT_TRUE(bounds.pulled_inwards(-3.0F * sign));
    EXPECT_TRUE(bounds.pulled_inwards(0.0F));
    bounds.release();
    EXPECT_FALSE(bounds.holds());
    bounds.look_ahead(range, stopping, {static_cast<std::int32_t>(1000.0F * sign), 0.0F, 0.0F, -5.0F * sign});
    EXPECT_FALSE(bounds.holds()) << "pushed inwards";
  }
}

// I2t: whichever of motor and amplifier is spent, the current is down at its rating, and says so.
TEST(Edges, MotorAndAmplifierAreSpentEachByItself) {
  for (const bool motor : {true, false}) {
    AxisParameters axis;
    axis.current_limit_A = 10.0F;
    (motor ? axis.motor_rated_A : axis.amplifier_rated_A) = 4.0F;
    axis.motor_thermal_s = axis.amplifier_thermal_s = 2.0F;
    ThermalLimit limit;
    int begins = 0, ends = 0;
    for (int i = 1; i < 40'000; ++i) {
      limit.step(axis, 1e-3F, i == 1 ? 0.0F : limit.limit_A());
      const bool down = limit.limit_A() < 4.0F + 0.01F * 6.0F + 1e-4F;
      if (limit.reduces() && begins == 0) begins = i;
      if (limit.spent() && ends == 0) ends = i;
      ASSERT_EQ(limit.spent(), down) << i << ' ' << limit.limit_A();
    }
    EXPECT_GT(begins, 0);
    EXPECT_GT(ends, begins + 100);
    for (int i = 0; i < 1000; ++i) limit.step(axis, 1e-3F, 0.0F);
    EXPECT_FALSE(limit.spent());
    EXPECT_FALSE(limit.reduces());
  }
}

}  // namespace
}  // namespace slipstack
