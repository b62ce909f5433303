// SPDX-License-Identifier: Apache-2.0
// The push at the first enabling: axes that are connected right, reversed at the encoder, at the motor, at
// both, and blocked at one side or both; how far they move, and what energy they have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/loop/axis_loop.h"

namespace slipstack::loop {
namespace {

struct Wiring {
  bool encoder_reversed = false;
  bool motor_reversed = false;
  bool encoder_stands = false;
  // The carriage stands this far from a stop on either side, m.
  double room_forward_m = 1.0;
  double room_backward_m = 1.0;
};

struct Outcome {
  bool enabled = false;
  Fault fault = Fault::kNone;
  double time_s = 0.0;
  double motion_um = 0.0;  // furthest from the start, also when coasting afterwards
  double energy_mJ = 0.0;  // largest kinetic energy
  double work_mJ = 0.0;    // of the motor until the verdict
};

// Another axis each time; a stop is a spring of 20 N/um, damped by half.
class Machine {
 public:
  Machine(std::uint64_t seed, const Wiring& wiring)
      : bench_(sim::draw_bench(sim::Setup::kPickAndPlace, seed)), wiring_(wiring), loop_(bench_.axis) {
    parameters = pick_and_place_parameters(bench_.axis);
    parameters.check_direction = true;
    from_m_ = loop_.plant.position_m();
  }
  void configure() {
    EXPECT_EQ(loop_.controller().configure(parameters, identified_model(bench_.axis, 0.02, 0.01)),
              ParameterStatus::kOk);
    for (int i = 0; i < 100; ++i) step();
  }

  void step() {
    const auto counts = static_cast<std::int32_t>(loop_.encoder.counts(loop_.plant.position_m()));
    loop_.board_encoder.next.counts = wiring_.encoder_stands     ? 4711
                                      : wiring_.encoder_reversed ? turned_counts_ - counts
                                                                 : counts;
    loop_.tick.run();
    loop_.controller().poll();
    const double set_A = loop_.motor.enabled ? static_cast<double>(loop_.motor.set_point_A) : 0.0;
    const double current_A = wiring_.motor_reversed ? -set_A : set_A;
    const double at_m = loop_.plant.position_m() - from_m_;
    const double beyond_m = at_m > wiring_.room_forward_m ? at_m - wiring_.room_forward_m
                                                          : std::min(0.0, at_m + wiring_.room_backward_m);
    constexpr double kStiffness = 2e7;
    const double damping = std::sqrt(kStiffness * bench_.axis.mass_kg);
    const double stop_N =
        beyond_m != 0.0 ? -kStiffness * beyond_m - damping * loop_.plant.velocity_mps() : 0.0;
    loop_.plant.step(current_A, kTick_s, stop_N);
    const double after_m = loop_.plant.position_m() - from_m_;
    work_J_ += bench_.axis.motor_constant_N_per_A * current_A * (after_m - at_m);
    furthest_m_ = std::max(furthest_m_, std::abs(after_m));
    const double v = loop_.plant.velocity_mps();
    energy_J_ = std::max(energy_J_, 0.5 * bench_.axis.mass_kg * v * v);
    loop_.clock.advance(1000);
    loop_.tick.main_loop_ran();
  }

  Outcome enable() {
    for (const int word : {0x06, 0x07}) {
      controller().command(static_cast<std::uint16_t>(word));
      step();
      step();
    }
    controller().command(std::uint16_t{0x0F});
    Outcome out;
    int ticks = 0;
    for (; ticks < 20'000 && !out.enabled && out.fault == Fault::kNone; ++ticks) {
      step();
      out.enabled = controller().state().state() == DriveState::kOperationEnabled;
      out.fault = controller().state().faults().latched();
    }
    out.time_s = ticks * kTick_s;
    out.work_mJ = 1e3 * work_J_;
    for (int i = 0; i < 5000; ++i) step();
    out.motion_um = 1e6 * furthest_m_;
    out.energy_mJ = 1e3 * energy_J_;
    return out;
  }

  /// The encoder turns round where it is, while the carriage moves.
  void reverse_encoder(double velocity_mps) {
    wiring_.encoder_reversed = true;
    turned_counts_ = 2 * loop_.board_encoder.next.counts;
    loop_.plant.reset(loop_.plant.position_m(), velocity_mps);
  }
  double velocity_mps() { return loop_.plant.velocity_mps(); }
  Controller& controller() { return loop_.controller(); }
  AxisLoop& loop() { return loop_; }
  AxisParameters parameters;

 private:
  sim::Bench bench_;
  Wiring wiring_;
  std::int32_t turned_counts_ = 0;
  AxisLoop loop_;
  double from_m_ = 0.0;
  double work_J_ = 0.0;
  double furthest_m_ = 0.0;
  double energy_J_ = 0.0;
};

Outcome first_enable(std::uint64_t seed, const Wiring& wiring) {
  Machine machine(seed, wiring);
  machine.configure();
  return machine.enable();
}

constexpr int kAxes = 12;

TEST(DirectionCheck, AnAxisConnectedRightIsEnabledAfterAShortPush) {
  Outcome worst;
  for (std::uint64_t seed = 1; seed <= kAxes; ++seed) {
    for (const bool both : {false, true}) {  // reversed twice is right
      const Outcome out = first_enable(seed, {.encoder_reversed = both, .motor_reversed = both});
      ASSERT_TRUE(out.enabled) << seed;
      ASSERT_EQ(out.fault, Fault::kNone);
      worst.time_s = std::max(worst.time_s, out.time_s);
      worst.motion_um = std::max(worst.motion_um, out.motion_um);
      worst.energy_mJ = std::max(worst.energy_mJ, out.energy_mJ);
      EXPECT_GT(out.motion_um, 15.0) << "it was pushed";
    }
  }
  std::printf("right: %.3f s, %.0f um, %.3f mJ\n", worst.time_s, worst.motion_um, worst.energy_mJ);
  EXPECT_LT(worst.motion_um, 60.0);
  EXPECT_LT(worst.energy_mJ, 2.4) << "2 A x 60 N/A x 20 um";
}

TEST(DirectionCheck, AReversedEncoderOrMotorIsAFaultWithinMicrometres) {
  Outcome worst;
  for (std::uint64_t seed = 1; seed <= kAxes; ++seed) {
    for (const bool encoder : {false, true}) {
      const Outcome out = first_enable(seed, {.encoder_reversed = encoder, .motor_reversed = !encoder});
      ASSERT_FALSE(out.enabled) << seed;
      ASSERT_EQ(out.fault, Fault::kDirection) << seed;
      worst.time_s = std::max(worst.time_s, out.time_s);
      worst.motion_um = std::max(worst.motion_um, out.motion_um);
      worst.energy_mJ = std::max(worst.energy_mJ, out.energy_mJ);
      EXPECT_LE(out.work_mJ, 2.4);
    }
  }
  std::printf("reversed: %.3f s, %.0f um, %.3f mJ\n", worst.time_s, worst.motion_um, worst.energy_mJ);
  EXPECT_LT(worst.motion_um, 60.0);
  EXPECT_GT(worst.motion_um, 20.0);
  EXPECT_LT(worst.energy_mJ, 2.4);
  EXPECT_EQ(error_code(Fault::kDirection), 0x8A00);
}

TEST(DirectionCheck, AtAnEndStopTheOtherDirectionTells) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Outcome right = first_enable(seed, {.room_forward_m = 2e-6});
    EXPECT_TRUE(right.enabled) << seed;
    const Outcome reversed = first_enable(seed, {.encoder_reversed = true, .room_forward_m = 2e-6});
    EXPECT_EQ(reversed.fault, Fault::kDirection) << seed;
    EXPECT_LT(std::max(right.motion_um, reversed.motion_um), 60.0);
  }
}

TEST(DirectionCheck, ABlockedAxisIsAFaultAndTheForceEnds) {
  Machine machine(3, {.room_forward_m = 2e-6, .room_backward_m = 2e-6});
  machine.configure();
  const Outcome out = machine.enable();
  EXPECT_FALSE(out.enabled);
  EXPECT_EQ(out.fault, Fault::kStall);
  EXPECT_FALSE(machine.loop().motor.enabled);
  EXPECT_LT(out.motion_um, 10.0);
  EXPECT_LT(out.time_s, 0.6) << "0.2 s up and 0.05 s held, twice";
  EXPECT_GT(out.time_s, 0.4);
}

// The axis is free and its encoder does not say so: a way that cannot go unseen ends the push (UnseenMotion).
TEST(DirectionCheck, AnEncoderThatStandsWhileTheAxisMovesIsABlockedAxis) {
  double worst_mJ = 0.0;
  for (std::uint64_t seed = 1; seed <= kAxes; ++seed) {
    const Outcome out = first_enable(seed, {.encoder_stands = true});
    EXPECT_EQ(out.fault, Fault::kStall) << seed;
    EXPECT_LT(out.time_s, 0.4) << "both ways";
    worst_mJ = std::max(worst_mJ, out.energy_mJ);
  }
  std::printf("stands: %.0f mJ\n", worst_mJ);
  EXPECT_LT(worst_mJ, 400.0);
  EXPECT_GT(worst_mJ, 50.0);
}

TEST(DirectionCheck, AnEncoderThatIsNotConnectedIsABlockedAxis) {
  Machine machine(3, {});
  machine.parameters.check_current_A = 0.05F;  // below breakaway: nothing moves by the distance
  machine.configure();
  EXPECT_EQ(machine.enable().fault, Fault::kStall);
}

TEST(DirectionCheck, IsRememberedUntilParametersAskForItAgain) {
  Machine machine(5, {});
  machine.configure();
  ASSERT_TRUE(machine.enable().enabled);
  EXPECT_FALSE(machine.controller().direction_unknown());
  machine.controller().command(std::uint16_t{0x06});
  machine.step();
  const Outcome again = machine.enable();
  EXPECT_TRUE(again.enabled);
  EXPECT_LT(again.time_s, 0.001) << "no second push";
  machine.controller().command(std::uint16_t{0x00});
  machine.step();
  machine.configure();
  EXPECT_TRUE(machine.controller().direction_unknown());
  EXPECT_GT(machine.enable().time_s, 0.01);
}

TEST(DirectionCheck, EndsAtOnceWhenEnablingIsTakenBack) {
  Machine machine(6, {});
  machine.configure();
  for (const int word : {0x06, 0x07, 0x0F}) {
    machine.controller().command(static_cast<std::uint16_t>(word));
    for (int i = 0; i < 300; ++i) machine.step();
  }
  ASSERT_TRUE(machine.loop().motor.enabled);
  EXPECT_EQ(machine.controller().state().state(), DriveState::kSwitchedOn);
  EXPECT_TRUE(machine.controller().driving());
  machine.controller().command(std::uint16_t{0x07});
  machine.step();
  EXPECT_FALSE(machine.loop().motor.enabled);
  EXPECT_TRUE(machine.controller().direction_unknown());
}

// The brake opens first, and nothing is pushed before it has; otherwise the axis would read as blocked.
TEST(DirectionCheck, WaitsForTheBrake) {
  Machine machine(8, {});
  machine.parameters.io.brake = 1;
  machine.configure();
  UserBounds user;
  user.brake_release_s = 0.05F;
  machine.controller().bound(user);
  machine.controller().set_outputs(0);
  for (const int word : {0x06, 0x07}) {
    machine.controller().command(static_cast<std::uint16_t>(word));
    machine.step();
    EXPECT_EQ(machine.controller().digital_outputs(), 0U);
  }
  machine.controller().command(std::uint16_t{0x0F});
  int stood = 0;
  for (; stood < 1000 && machine.controller().digital_outputs() == 0; ++stood) machine.step();
  EXPECT_EQ(stood, 202) << "20 ms without motion, and the tick that opens it";
  int waited = 1;
  for (; waited < 1000; ++waited) {
    machine.step();
    ASSERT_EQ(machine.controller().digital_outputs(), 1U) << waited;
    ASSERT_TRUE(machine.loop().motor.enabled);
    if (machine.loop().motor.set_point_A != 0.0F) break;
  }
  EXPECT_EQ(waited, 500);
  while (machine.controller().state().state() == DriveState::kSwitchedOn) {
    ASSERT_EQ(machine.controller().digital_outputs(), 1U) << "open until operation is enabled";
    machine.step();
  }
  EXPECT_EQ(machine.controller().state().state(), DriveState::kOperationEnabled);
  EXPECT_FALSE(machine.controller().direction_unknown());
  machine.controller().command(std::uint16_t{0x00});
  machine.step();
  EXPECT_EQ(machine.controller().digital_outputs(), 0U);
}

// The encoder turns round in motion, and somebody resets the fault and enables again and again: nothing is
// enabled before the carriage stands, it never gains speed, and the push tells what is wrong.
TEST(DirectionCheck, AnEncoderThatTurnsRoundGainsNoSpeedByBeingEnabledAgain) {
  for (const bool checked : {true, false}) {
    for (const double speed_mps : {0.05, 0.28, -0.28}) {
      Machine machine(9, {});
      machine.parameters.check_direction = checked;
      machine.configure();
      ASSERT_TRUE(machine.enable().enabled);
      machine.reverse_encoder(speed_mps);
      double fastest_mps = 0.0;
      int enabled = 0;
      Fault last = Fault::kNone;
      for (int i = 0; i < 60000; ++i) {
        const DriveState state = machine.controller().state().state();
        const Fault fault = machine.controller().state().faults().latched();
        if (fault != Fault::kNone) last = fault;
        std::uint16_t word = 0x0F;
        if (state == DriveState::kFault) word = i % 20 == 0 ? 0x80 : 0x00;
        if (state == DriveState::kSwitchOnDisabled) word = 0x06;
        if (state == DriveState::kReadyToSwitchOn) word = 0x07;
        machine.controller().command(word);
        const bool was_enabled = state == DriveState::kOperationEnabled;
        const double before_mps = std::abs(machine.velocity_mps());
        machine.step();
        const bool is_enabled = machine.controller().state().state() == DriveState::kOperationEnabled;
        if (is_enabled && !was_enabled) {
          ++enabled;
          EXPECT_LT(before_mps, 2e-3) << "it stands";
        }
        // The first fault takes some way to be seen.
        if (i > 2000) fastest_mps = std::max(fastest_mps, std::abs(machine.velocity_mps()));
      }
      if (checked) {
        EXPECT_EQ(last, Fault::kDirection) << speed_mps;
        EXPECT_EQ(enabled, 0) << speed_mps;
        EXPECT_LE(fastest_mps, std::abs(speed_mps) + 0.25);
      } else {
        EXPECT_GT(enabled, 0) << "nobody checks";
        EXPECT_LE(fastest_mps, 0.4) << "from rest, and not added up";
      }
    }
  }
}

// An offset is not added to the push, and an encoder that fails in it ends it.
TEST(DirectionCheck, PushesWithItsOwnForceOnly) {
  Machine machine(7, {});
  machine.configure();
  machine.controller().set_torque(300.0F, 200.0F);
  for (const int word : {0x06, 0x07, 0x0F}) {
    machine.controller().command(static_cast<std::uint16_t>(word));
    for (int i = 0; i < 205; ++i) machine.step();
  }
  ASSERT_TRUE(machine.loop().motor.enabled);
  EXPECT_LT(std::abs(machine.loop().motor.set_point_A), 0.01F);
  machine.loop().board_encoder.next.valid = false;
  machine.step();
  EXPECT_EQ(machine.controller().state().state(), DriveState::kFault);
  EXPECT_FALSE(machine.loop().motor.enabled);
}

}  // namespace
}  // namespace slipstack::loop
