// SPDX-License-Identifier: Apache-2.0
// The parts of the controller against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <initializer_list>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include "firmware/control/controller.h"
#include "firmware/control/reference/segment_queue.h"
#include "firmware/control/supervision/holding_brake.h"

namespace slipstack {
namespace {

constexpr float kTick_s = 1e-4F;

TEST(StateEstimate, VelocityNoiseOfQuantisedCountsIsWhatItsHeaderSays) {
  const auto gains = StateEstimate::gains(1e-6F, kTick_s, 400.0F);
  StateEstimate estimate;
  estimate.reset(0);
  double x_m = 0.0, squares = 0.0, worst_m = 0.0;
  int samples = 0;
  for (int i = 0; i < 400000; ++i) {
    // A velocity that wanders, so that counts come at all phases.
    const double t = i * 1e-4;
    const double v = 0.03 * std::sin(0.5 * t) + 0.0123;
    const double a = 0.03 * 0.5 * std::cos(0.5 * t);
    x_m += v * 1e-4;
    estimate.step(gains, static_cast<std::int32_t>(std::lround(x_m * 1e6)), static_cast<float>(a));
    if (i < 2000) continue;
    const double error = static_cast<double>(estimate.velocity_mps()) - v;
    squares += error * error;
    const double position = estimate.counts() * 1e-6 + static_cast<double>(estimate.offset_m());
    worst_m = std::max(worst_m, std::abs(position - x_m));
    ++samples;
  }
  const double deviation = std::sqrt(squares / samples);
  EXPECT_LT(deviation, 4.0e-5);
  EXPECT_GT(deviation, 0.5e-5);
  EXPECT_LT(worst_m, 1.2e-6);
}

// A disturbance that steps appears as 1 - (1 + wt + (wt)^2 / 2) exp(-wt): three poles at the bandwidth.
TEST(StateEstimate, DisturbanceComesThroughAThirdOrderLowPass) {
  const double w = 300.0;
  const auto gains = StateEstimate::gains(1e-9F, kTick_s, static_cast<float>(w));
  StateEstimate estimate;
  estimate.reset(0);
  for (int i = 1; i < 500; ++i) {
    const double t = i * 1e-4;
    estimate.step(gains, static_cast<std::int32_t>(std::lround(0.5 * 2.0 * t * t * 1e9)), 0.0F);
    const double should = 2.0 * (1.0 - (1.0 + w * t + 0.5 * w * w * t * t) * std::exp(-w * t));
    ASSERT_NEAR(static_cast<double>(estimate.disturbance_mps2()), should, 0.05) << i;
  }
}

TEST(StateEstimate, TheCounterMayWrap) {
  const auto gains = StateEstimate::gains(1e-6F, kTick_s, 400.0F);
  StateEstimate here, far;
  here.reset(0);
  far.reset(2147483000);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    here.step(gains, static_cast<std::int32_t>(3 * i), 0.0F);
    far.step(gains, static_cast<std::int32_t>(2147483000U + 3 * i), 0.0F);
    ASSERT_EQ(here.velocity_mps(), far.velocity_mps());
    ASSERT_EQ(here.offset_m(), far.offset_m());
  }
}

TEST(Notch, HasItsDepthAtTheCentreAndUnityElsewhere) {
  const auto gains = Notch::gains(200.0F, 0.1F, 0.05F, kTick_s);
  const auto amplitude = [&](double frequency_Hz) {
    Notch notch;
    std::complex<double> sum = 0.0;
    for (int i = 0; i < 40000; ++i) {
      const double phase = 2.0 * std::numbers::pi * frequency_Hz * i * 1e-4;
      const double out = static_cast<double>(notch.step(gains, static_cast<float>(std::sin(phase))));
      if (i >= 20000) sum += out * std::polar(1.0, -phase);
    }
    return 2.0 * std::abs(sum) / 20000.0;
  };
  EXPECT_NEAR(amplitude(200.0), 0.05, 1e-3);
  EXPECT_NEAR(amplitude(10.0), 1.0, 1e-3);
  EXPECT_NEAR(amplitude(3000.0), 1.0, 1e-2);
  // -3 dB of a notch with depth 0 lies at about f (1 +- damping).
  EXPECT_NEAR(amplitude(220.0), 0.7, 0.03);
}

TEST(CurrentLimit, HoldsMagnitudeAndRateAndSaysWhich) {
  CurrentLimit limit;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> wanted(-30.0F, 30.0F);
  float last_A = 0.0F;
  for (int i = 0; i < 20000; ++i) {
    std::uint16_t limits = 0;
    const float want_A = wanted(random) * (i % 3 == 0 ? 0.1F : 1.0F);
    const float is_A = limit.step(10.0F, 2.0F, want_A, limits);
    ASSERT_LE(std::abs(is_A), 10.0F);
    ASSERT_LE(std::abs(is_A - last_A), 2.00001F);
    ASSERT_EQ(limits == 0, is_A == want_A);
    last_A = is_A;
  }
}

// 119 h after the start the counter of ticks wraps; the level of the friction goes on as it was.
TEST(FeedForward, TheTimeOfDriftDoesNotWrap) {
  ModelParameters parameters{};
  std::get<EffectParameters<Coulomb<float>, float>>(parameters) = {{10.0F}, {1e-3F}, true};
  std::get<EffectParameters<Drift<float>, float>>(parameters) = {{0.5F}, {1e6F, 1e9F}, true};
  FrictionModel<float> model;
  model.prepare(parameters, Scales<float>{kTick_s, 1e-6F});
  FeedForward::Scales scales;
  scales.mps_per_count = 1e-2F;
  scales.mps2_per_count = 1e2F;
  scales.resolution_m = 1e-6F;
  FeedForward feedforward;
  const PositionReference reference;
  UpTime time;
  ReferencePoint moving;
  moving.velocity = 10.0F;
  const auto force_N = [&](std::uint32_t tick) {
    model.refresh(time.at(tick, kTick_s));
    return feedforward.step(model, scales, moving, 1.0F, reference);
  };
  const auto expected_N = [](double ticks) { return 10.0 * (1.0 + 0.5 * (1.0 - std::exp(-ticks * 1e-10))); };
  EXPECT_NEAR(force_N(1), 10.0F, 1e-4F);
  EXPECT_NEAR(force_N(0x80000000U), expected_N(0x1p31), 2e-3);
  const float before_N = force_N(0xFFFFFFFFU);
  EXPECT_NEAR(before_N, expected_N(0x1p32), 2e-3);
  EXPECT_NEAR(force_N(0), before_N, 1e-4F);
  EXPECT_NEAR(force_N(0x80000000U), expected_N(0x1.8p32), 2e-3);
  EXPECT_NEAR(force_N(0), expected_N(0x1p33), 2e-3);
}

constexpr StopTimes kTimes{.quick_stop = 50, .slow_down = 50};

// The force of the hysteresis is held over a tick: it is that of the middle of the tick, to a step, with the
// steps finer and coarser than a count.
TEST(FeedForward, SeesTheReferenceInTheMiddleOfTheTick) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<float> within(0.0F, 1.0F);
  for (const int shift : {4, 1, 0, -3}) {
    FeedForward::Scales scales;
    scales.shift_up = std::max(shift, 0);
    scales.shift_down = std::max(-shift, 0);
    scales.steps_per_count = std::ldexp(1.0F, shift);
    for (int i = 0; i < 1000; ++i) {
      const float velocity = 200.0F * (within(random) - 0.5F);
      const ReferencePoint at{static_cast<std::int32_t>(1e6F * (within(random) - 0.5F)), within(random),
                              velocity, 0.0F};
      const double middle =
          at.counts + static_cast<double>(at.fraction) + 0.5 * static_cast<double>(velocity);
      const double seen = FeedForward::displacement(scales, at);
      // Rounded twice: the whole counts and what is beyond them.
      ASSERT_NEAR(seen, std::ldexp(middle, shift), shift < 0 ? 2.0 : 1.0) << shift << ' ' << middle;
    }
  }
}

// An axis that comes to rest at 100.44 counts reads 100, and moves by 0.06 to read 101: only so much may move
// the hysteresis. From the middle of the count it would be half a count, and the count back would not undo
// it.
TEST(FeedForward, AtRestACountMovesWhatTheEstimateDoesNotKnow) {
  FeedForward::Scales scales;
  scales.shift_up = 4;
  scales.steps_per_count = 16.0F;
  scales.band = 8;
  scales.rest = 1e-3F;
  scales.steps_per_m = 16.0e6F;
  const StateEstimate::Gains gains = StateEstimate::gains(1e-6F, kTick_s, 400.0F);
  const auto place_after = [&](float beyond, std::initializer_list<std::int32_t> counts) {
    FeedForward feedforward;
    feedforward.start(scales, 90);
    StateEstimate estimate;
    for (std::int32_t at = 91; at <= 100; ++at) {
      feedforward.observe(scales, {at, 0.0F, 1.0F, 0.0F}, at, estimate, false);
      // Without a difference to the counts a velocity carries it where it shall be.
      estimate.reset(at);
      estimate.correct_velocity(beyond * 1e-6F / kTick_s);
      estimate.step({gains.resolution_m, gains.counts_per_m, gains.tick_s, 0.0F, 0.0F, 0.0F}, at, 0.0F);
    }
    for (const std::int32_t read : counts)
      feedforward.observe(scales, {100, 0.0F, 0.0F, 0.0F}, read, estimate, false);
    return feedforward.place();
  };
  EXPECT_EQ(place_after(0.44F, {100, 100}), 1600);
  EXPECT_EQ(place_after(0.44F, {100, 101, 100, 101, 100}), 1601);
  EXPECT_EQ(place_after(0.0F, {100, 101, 100}), 1608);
  EXPECT_EQ(place_after(-0.44F, {100, 99, 100}), 1599);
  // What truly moves it does so by the counts less what lies within the dead band.
  EXPECT_EQ(place_after(0.44F, {100, 101, 102, 103}), 1600 + 3 * 16 - 8 - 7);
  // An estimate beyond the count that is read is not believed, and moves nothing.
  EXPECT_EQ(place_after(3.0F, {100, 101, 100}), 1600);
}

TEST(StateMachine, FollowsEveryTransitionOfTheFigure) {
  const auto run = [](StateMachine& machine, int control) {
    machine.step(
        static_cast<std::uint16_t>(control), Fault::kNone, true, [] { return true; }, kTimes);
    return machine.state();
  };
  StateMachine machine;
  EXPECT_EQ(machine.state(), DriveState::kNotReadyToSwitchOn);
  EXPECT_EQ(run(machine, 0x0F), DriveState::kSwitchOnDisabled);  // not straight on
  EXPECT_EQ(run(machine, 0x0F), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(run(machine, 0x06), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(run(machine, 0x07), DriveState::kSwitchedOn);
  EXPECT_EQ(run(machine, 0x06), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(run(machine, 0x07), DriveState::kSwitchedOn);
  EXPECT_EQ(run(machine, 0x0F), DriveState::kOperationEnabled);
  EXPECT_EQ(run(machine, 0x07), DriveState::kSwitchedOn);
  EXPECT_EQ(run(machine, 0x0F), DriveState::kOperationEnabled);
  EXPECT_EQ(run(machine, 0x06), DriveState::kReadyToSwitchOn);
  run(machine, 0x07);
  run(machine, 0x0F);
  EXPECT_EQ(run(machine, 0x0D), DriveState::kSwitchOnDisabled);
  run(machine, 0x06);
  run(machine, 0x07);
  run(machine, 0x0F);
  EXPECT_EQ(run(machine, 0x0B), DriveState::kQuickStopActive);
  run(machine, 0x0F);
  EXPECT_EQ(run(machine, 0x0F), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(status_word(DriveState::kOperationEnabled), 0x27);
}

TEST(StateMachine, AStopThatDoesNotEndIsAFault) {
  StateMachine machine;
  for (const int control : {0x06, 0x06, 0x07, 0x0F}) {
    machine.step(
        static_cast<std::uint16_t>(control), Fault::kNone, true, [] { return true; }, kTimes);
  }
  ASSERT_TRUE(machine.driving());
  for (int i = 0; i < 52; ++i)
    machine.step(
        0x0B, Fault::kNone, true, [] { return false; }, kTimes);
  EXPECT_EQ(machine.state(), DriveState::kFault);
  EXPECT_EQ(machine.faults().count(Fault::kStopTimeout), 1);
}

ModelParameters plain_model(float mass_kg) {
  ModelParameters model{};
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  inertia = {{mass_kg}, {}, true};
  return model;
}

// Positions of the reference are counted in the encoder's counts: what they cannot represent is refused, with
// the reason, before anything moves.
TEST(Parameters, AnEncoderIsRefusedThatTheReferenceCannotCount) {
  ModelParameters model{};
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  inertia.enabled = true;
  inertia.gains = {35.0F};
  AxisParameters axis;
  for (const float resolution_m : {1e-9F, 5e-9F, 1e-8F, 1e-6F, 1e-4F}) {
    axis.encoder_resolution_m = resolution_m;
    EXPECT_EQ(check(axis, model), ParameterStatus::kOk) << resolution_m;
  }
  // 2 m/s at 10 kHz are 2^18 counts per tick of 0.763 nm.
  axis.encoder_resolution_m = 0.77e-9F;
  EXPECT_EQ(check(axis, model), ParameterStatus::kOk);
  axis.encoder_resolution_m = 0.75e-9F;
  EXPECT_EQ(check(axis, model), ParameterStatus::kEncoderTooFine);
  axis.velocity_limit_mps = 1.9F;
  EXPECT_EQ(check(axis, model), ParameterStatus::kOk);
  axis = {};
  axis.encoder_resolution_m = 1e-9F;
  axis.quick_stop_mps2 = 1000.0F;
  axis.acceleration_limit_mps2 = 1000.0F;
  EXPECT_EQ(check(axis, model), ParameterStatus::kOk);
  axis = {};
  axis.encoder_resolution_m = 1e-3F;
  axis.tick_s = 2e-5F;
  axis.jerk_limit_mps3 = 1.0F;
  EXPECT_EQ(check(axis, model), ParameterStatus::kEncoderTooCoarse);
}

// What moves is inertia and payload together, each as far as it is in the model.
TEST(Parameters, TheMassIsInertiaAndPayload) {
  for (const bool has_inertia : {false, true}) {
    for (const bool has_payload : {false, true}) {
      ModelParameters model;
      auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
      auto& payload = std::get<EffectParameters<PayloadMass<float>, float>>(model);
      inertia.enabled = has_inertia;
      inertia.gains[0] = 30.0F;
      payload.enabled = has_payload;
      payload.gains[0] = 4.5F;
      EXPECT_EQ(mass_kg(model), (has_inertia ? 30.0F : 0.0F) + (has_payload ? 4.5F : 0.0F));
    }
  }
}

TEST(Parameters, NothingOutOfBoundsPasses) {
  const AxisParameters good;
  EXPECT_EQ(check(good, plain_model(35.0F)), ParameterStatus::kOk);
  EXPECT_EQ(check(good, plain_model(0.0F)), ParameterStatus::kNoMass);
  EXPECT_EQ(check(good, plain_model(-1.0F)), ParameterStatus::kGainOutOfBounds);
  for (const detail::Bound& bound : detail::kAxisBounds) {
    const float inf = std::numeric_limits<float>::infinity();
    for (const float wrong :
         {bound.lower - 1.0F - bound.lower, bound.upper * 1.01F, inf, -inf, std::nanf("")}) {
      if (wrong >= bound.lower && wrong <= bound.upper) continue;
      AxisParameters bad = good;
      bad.*bound.member = wrong;
      EXPECT_EQ(check(bad, plain_model(35.0F)), ParameterStatus::kAxisOutOfBounds);
    }
  }
  ModelParameters model = plain_model(35.0F);
  auto& stribeck = std::get<EffectParameters<Stribeck<float>, float>>(model);
  stribeck.enabled = true;
  stribeck.shapes = {0.01F, std::nanf("")};
  EXPECT_EQ(check(good, model), ParameterStatus::kShapeOutOfBounds);
}

// What is not finite in the memory of an effect goes with the fault: the axis can be enabled again.
TEST(Controller, AnEffectThatIsNotFiniteIsForgottenWithTheFault) {
  const auto controller = std::make_unique<Controller>();
  ModelParameters parameters = plain_model(35.0F);
  std::get<EffectParameters<Coulomb<float>, float>>(parameters) = {{10.0F}, {1e-3F}, true};
  std::get<EffectParameters<FrictionalLag<float>, float>>(parameters) = {
      {0.2F, 0.0F}, {0.01F, 1.0F, 0.1F, 1.0F}, true};
  std::get<EffectParameters<StructuralResonance<float>, float>>(parameters) = {
      {1.0F, 0.0F, 0.0F}, {40.0F, 0.02F}, true};
  ASSERT_EQ(controller->configure(AxisParameters{}, parameters), ParameterStatus::kOk);
  TickInputs in;
  const auto step = [&] {
    in.current.current_A = controller->step(in).current_A;
    return controller->state().state();
  };
  step();
  const auto enable = [&] {
    for (const int control : {0x80, 0x00, 0x06, 0x07, 0x0F}) {
      controller->command(static_cast<std::uint16_t>(control));
      step();
      step();
    }
    return controller->state().state();
  };
  ASSERT_EQ(enable(), DriveState::kOperationEnabled);
  // A current flows, until it is taken off.
  controller->command(Command{0x0FU, 0.0F, 30.0F});
  for (int i = 0; i < 3; ++i) step();
  ASSERT_GT(controller->output().current_A, 0.1F);
  // The model is the tick's own: nobody else can put this there.
  Sample<float> poison;
  poison.velocity_mps = poison.acceleration_mps2 = std::nanf("");
  const_cast<ControlSet&>(controller->parameters()).model.step(poison);  // NOLINT(*-pro-type-const-cast)
  EXPECT_EQ(step(), DriveState::kFault);
  EXPECT_EQ(controller->state().faults().latched(), Fault::kNotFinite);
  EXPECT_EQ(controller->output().current_A, 0.0F);
  EXPECT_FALSE(controller->output().driving);
  controller->command(Command{0x0FU, 0.0F, 0.0F});
  EXPECT_EQ(enable(), DriveState::kOperationEnabled);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(step(), DriveState::kOperationEnabled) << i;
}

// Other parameters in motion: the current changes by no more than the motion itself makes it change.
TEST(Parameters, AChangeInMotionDoesNotMakeTheForceJump) {
  const auto controller = std::make_unique<Controller>();
  AxisParameters axis;
  axis.current_rate_A_per_s = 1e7F;
  axis.current_limit_A = 40.0F;
  axis.over_current_A = 50.0F;
  ModelParameters model = plain_model(35.0F);
  std::get<EffectParameters<Viscous<float>, float>>(model) = {{10.0F}, {}, true};
  ASSERT_EQ(controller->configure(axis, model), ParameterStatus::kOk);
  TickInputs in;
  const auto step = [&] {
    const ControlOutput& out = controller->step(in);
    in.encoder.counts = out.reference_counts;
    in.current.current_A = out.current_A;
    return out.current_A;
  };
  step();  // takes the parameters
  for (const int control : {0x06, 0x07, 0x0F}) {
    controller->command(static_cast<std::uint16_t>(control));
    step();
    step();
  }
  ASSERT_EQ(controller->state().state(), DriveState::kOperationEnabled);
  ASSERT_EQ(controller->move_to(300000), PlanStatus::kOk);
  float last_A = 0.0F;
  for (int i = 0; i < 1000; ++i) last_A = step();
  // 200 N s/m more at 1 m/s and beyond: 3 A.
  std::get<EffectParameters<Viscous<float>, float>>(model).gains[0] = 210.0F;
  axis.velocity_gain_N_s_per_m = 9000.0F;
  ASSERT_EQ(controller->configure(axis, model), ParameterStatus::kOk);
  EXPECT_TRUE(controller->change_pending());
  const float before_A = last_A;
  float largest_step_A = 0.0F;
  for (int i = 0; i < 600; ++i) {
    const float now_A = step();
    largest_step_A = std::max(largest_step_A, std::abs(now_A - last_A));
    last_A = now_A;
  }
  EXPECT_FALSE(controller->change_pending());
  // At once it would be 5 A. Let in over 20 ms it is 0.08 A a tick, the jerk of the move 0.09 A, and the
  // estimate answers to a force that this axis without dynamics does not feel.
  EXPECT_LT(largest_step_A, 0.25F);
  EXPECT_GT(largest_step_A, 0.1F);
  EXPECT_GT(std::abs(last_A - before_A), 1.0F);
  EXPECT_EQ(controller->parameters().axis.velocity_gain_N_s_per_m, 9000.0F);
}

TEST(SegmentQueue, RefusesWhatHasNoTickAndWhatFindsNoRoom) {
  SegmentQueue queue;
  EXPECT_FALSE(queue.push({.ticks = 0}));
  EXPECT_FALSE(queue.push({.ticks = -1}));
  EXPECT_EQ(queue.pushed(), 0U) << "refused, and nothing taken";
  for (std::uint32_t i = 0; i < SegmentQueue::kCapacity; ++i) {
    EXPECT_TRUE(queue.push({.ticks = 1 + static_cast<std::int64_t>(i)})) << i;
  }
  EXPECT_EQ(queue.free(), 0U);
  EXPECT_FALSE(queue.push({.ticks = 99}));
  ASSERT_NE(queue.after(0), nullptr);
  EXPECT_EQ(queue.after(0)->ticks, 1) << "the oldest is not overwritten";
  queue.free_up_to(1);
  EXPECT_TRUE(queue.push({.ticks = 99}));
}

// A closing that was broken off does not shorten the next one: the axis is held until the brake is closed.
TEST(HoldingBrake, ClosesAnewInFullAfterARest) {
  HoldingBrake brake;
  EXPECT_FALSE(brake.close(3));
  EXPECT_FALSE(brake.close(3));
  brake.rest();
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(brake.close(3)) << i;
  EXPECT_TRUE(brake.close(3));
  EXPECT_FALSE(brake.open(2));
  brake.rest();
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(brake.open(2)) << i;
  EXPECT_TRUE(brake.open(2));
}

}  // namespace
}  // namespace slipstack
