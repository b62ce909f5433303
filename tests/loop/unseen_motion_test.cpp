// SPDX-License-Identifier: Apache-2.0
// An encoder that stands still while the axis moves, in torque and in position mode: found before the axis
// has much energy. And what must not be taken for it: stops, clamps, friction that the model does not know, a
// slow axis.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/loop/axis_loop.h"

namespace slipstack::loop {
namespace {

constexpr int kSeeds = 12;

/// An axis whose encoder may stick, in torque mode unless said otherwise.
class PushedAxis {
 public:
  /// `known`: the model has what differs.
  explicit PushedAxis(std::uint64_t seed, const std::function<void(sim::Axis&)>& differs = {},
                      bool known = false)
      : bench_(sim::draw_bench(sim::Setup::kPickAndPlace, seed)) {
    if (differs && known) differs(bench_.axis);
    model_ = identified_model(bench_.axis, 0.02, 0.01);
    parameters_ = pick_and_place_parameters(bench_.axis);
    if (differs && !known) differs(bench_.axis);
    loop_ = std::make_unique<AxisLoop>(bench_.axis, 0.2);
    loop_->reads = [this](std::int64_t counts) {
      if (!stuck) at_ = static_cast<std::int32_t>(counts);
      ++reading_;
      const std::int32_t dither = stuck && dithers && reading_ % 7 < 3 ? 1 : 0;
      return EncoderReading{.counts = at_ + dither};
    };
    EXPECT_EQ(controller().configure(parameters_, model_), ParameterStatus::kOk);
    loop_->run(0.01);
    EXPECT_TRUE(loop_->enable());
    loop_->run(0.05);
  }

  void torque_mode() { controller().command_all(0x0FU | kTorqueMode); }
  /// With this force over time until a fault or the end. True at a fault.
  bool push(double seconds, const std::function<double(double time_s)>& force_N) {
    for (int i = 0; i < static_cast<int>(seconds / kTick_s) && fault() == Fault::kNone; ++i) {
      controller().set_torque(static_cast<float>(force_N(i * kTick_s)), 0.0F);
      step();
    }
    return fault() != Fault::kNone;
  }
  void step() {
    loop_->step();
    if (++ticks_ % 10 == 0) controller().poll();
    energy_J = std::max(energy_J, 0.5 * bench_.axis.mass_kg * velocity() * velocity());
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kTick_s) && fault() == Fault::kNone; ++i) step();
  }

  Controller& controller() { return loop_->controller(); }
  AxisLoop& loop() { return *loop_; }
  Fault fault() { return controller().state().faults().latched(); }
  double velocity() { return loop_->plant.velocity_mps(); }
  double friction_N() const { return bench_.axis.curve.saturation_N(); }

  bool stuck = false;
  bool dithers = false;
  double energy_J = 0.0;  ///< largest so far

 private:
  sim::Bench bench_;
  ModelParameters model_;
  AxisParameters parameters_;
  std::unique_ptr<AxisLoop> loop_;
  std::int32_t at_ = 0;
  int reading_ = 0;
  int ticks_ = 0;
};

// ---- it stands still ----

TEST(UnseenMotion, AForceOnAnEncoderThatStandsIsAFault) {
  double worst_J = 0.0;
  double worst_s = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const double force_N : {-600.0, -100.0, 50.0, 200.0, 600.0}) {
      for (const bool dithers : {false, true}) {
        PushedAxis axis(seed);
        axis.torque_mode();
        axis.stuck = true;
        axis.dithers = dithers;
        const double begin_s = axis.loop().time_s();
        ASSERT_TRUE(axis.push(1.0, [&](double) { return force_N; })) << force_N;
        EXPECT_EQ(axis.fault(), Fault::kEncoderStands) << force_N;
        EXPECT_FALSE(axis.loop().motor.enabled);
        worst_J = std::max(worst_J, axis.energy_J);
        worst_s = std::max(worst_s, axis.loop().time_s() - begin_s);
        EXPECT_GT(axis.energy_J, 1e-4) << "it did move";
      }
    }
  }
  std::printf("stands: %.3f s, %.2f J\n", worst_s, worst_J);
  EXPECT_LT(worst_J, 0.7) << "600 N x 1 mm, and what is below the friction";
  EXPECT_GT(worst_J, 0.4);
  EXPECT_LT(worst_s, 0.1);
  EXPECT_EQ(error_code(Fault::kEncoderStands), 0x7310);
  EXPECT_EQ(reaction_to(Fault::kEncoderStands), FaultReaction::kRelease);
}

TEST(UnseenMotion, AForceThatRisesSlowlyIsFoundToo) {
  double worst_J = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const double rate : {30.0, 100.0, -1000.0}) {
      PushedAxis axis(seed);
      axis.torque_mode();
      axis.stuck = true;
      ASSERT_TRUE(axis.push(3.0, [&](double t) { return rate * t; })) << rate;
      EXPECT_EQ(axis.fault(), Fault::kEncoderStands);
      worst_J = std::max(worst_J, axis.energy_J);
    }
  }
  std::printf("rises: %.2f J\n", worst_J);
  // At 30 N/s it takes 0.3 s from the friction to a quarter more and 1 % of the peak.
  EXPECT_LT(worst_J, 2.2);
  EXPECT_GT(worst_J, 1.0);
}

// It stops dead where it is, while the carriage goes on.
TEST(UnseenMotion, AnEncoderThatStopsInMotionIsAFault) {
  // From 0.17 m/s on it is a jump (7306).
  for (const double speed_mps : {0.06, 0.13, -0.13}) {
    PushedAxis axis(5);
    axis.torque_mode();
    const double force_N = std::copysign(100.0, speed_mps);
    for (int i = 0; i < 5000 && std::abs(axis.velocity()) < std::abs(speed_mps); ++i)
      axis.push(kTick_s, [&](double) { return force_N; });
    ASSERT_NEAR(axis.velocity(), speed_mps, 0.01);
    ASSERT_EQ(axis.fault(), Fault::kNone);
    axis.stuck = true;
    const double from_m = axis.loop().plant.position_m();
    ASSERT_TRUE(axis.push(0.5, [&](double) { return force_N; })) << speed_mps;
    EXPECT_EQ(axis.fault(), Fault::kEncoderStands) << speed_mps;
    EXPECT_LT(std::abs(axis.loop().plant.position_m() - from_m), 1.5e-3);
    EXPECT_LT(axis.energy_J, 0.5 * 35.5 * std::pow(std::abs(speed_mps) + 0.05, 2));
  }
}

// The integral winds up over an error of less than a count, until the axis breaks away.
TEST(UnseenMotion, AnEncoderThatStandsWhileThePositionIsHeldIsAFault) {
  double worst_J = 0.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    PushedAxis axis(seed);
    axis.stuck = true;
    // Half a count and more away for ever.
    axis.controller().set_torque(0.0F, 8.0F);
    axis.run(60.0);
    EXPECT_NE(axis.fault(), Fault::kNone) << seed;
    worst_J = std::max(worst_J, axis.energy_J);
  }
  std::printf("held: %.2f J\n", worst_J);
  EXPECT_LT(worst_J, 5.0);
}

TEST(UnseenMotion, AMoveWithAnEncoderThatStandsIsAFaultEarly) {
  for (const float counts_per_tick : {0.05F, 1.0F, 20.0F}) {
    PushedAxis axis(4);
    axis.stuck = true;
    ASSERT_EQ(axis.controller().move_to(axis.controller().reference().counts() + 50000,
                                        {counts_per_tick, 0.01F, 0.01F, 0.0005F}),
              PlanStatus::kOk);
    axis.run(2.0);
    EXPECT_NE(axis.fault(), Fault::kNone) << counts_per_tick;
    std::printf("move at %.4f m/s: %X, %.2f J\n", static_cast<double>(counts_per_tick) * 1e-2,
                error_code(axis.fault()), axis.energy_J);
    EXPECT_LT(axis.energy_J, 1.0) << counts_per_tick;
  }
}

TEST(UnseenMotion, WithoutFrictionInTheModelItTakesTheCurrentOfTheCheck) {
  for (const double force_N : {100.0, 150.0}) {
    PushedAxis axis(3);
    ModelParameters mass = identified_model(sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis, 0.0, 0.0);
    std::get<1>(mass).enabled = false;
    ASSERT_EQ(axis.controller().configure(axis.controller().parameters().axis, mass), ParameterStatus::kOk);
    axis.run(0.1);
    axis.torque_mode();
    axis.stuck = true;
    // 2 A are 120 N.
    EXPECT_EQ(axis.push(0.3, [&](double) { return force_N; }), force_N > 120.0) << force_N;
  }
}

// ---- what is not that ----

// Pressed against a stop, up and down, in steps and slowly, as long as nothing is stalled.
TEST(UnseenMotion, AnAxisThatPressesAgainstAStopIsNoFault) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const double stiffness : {1e6, 2e7}) {
      PushedAxis axis(seed);
      const double here_m = axis.loop().plant.position_m();
      axis.loop().stops = sim::EndStops{.negative_m = -1.0,
                                        .positive_m = here_m + 2e-4,
                                        .stiffness_N_per_m = stiffness,
                                        .damping_N_s_per_m = std::sqrt(stiffness * 35.0)};
      axis.torque_mode();
      EXPECT_FALSE(axis.push(0.5, [](double) { return 100.0; })) << seed;
      EXPECT_FALSE(
          axis.push(4.0, [](double t) { return 100.0 + 190.0 * std::sin(3.0 * t) * std::sin(3.0 * t); }));
      EXPECT_FALSE(axis.push(2.0, [](double t) { return 290.0 - 100.0 * t; }));
      EXPECT_FALSE(axis.push(2.0, [](double t) { return t < 1.0 ? 250.0 : 120.0; }));
      EXPECT_FALSE(axis.push(2.0, [](double t) { return 120.0 + 10.0 * t; }));
      EXPECT_EQ(axis.fault(), Fault::kNone) << std::hex << error_code(axis.fault());
      EXPECT_GT(axis.loop().plant.position_m(), here_m + 1.5e-4) << "it is there";
    }
  }
}

TEST(UnseenMotion, AStopWithMoreThanTheStallCurrentIsAStall) {
  PushedAxis axis(2);
  const double here_m = axis.loop().plant.position_m();
  axis.loop().stops = sim::EndStops{
      .negative_m = -1.0, .positive_m = here_m + 2e-4, .stiffness_N_per_m = 2e7, .damping_N_s_per_m = 2e4};
  axis.torque_mode();
  EXPECT_TRUE(axis.push(2.0, [](double) { return 500.0; }));
  EXPECT_EQ(axis.fault(), Fault::kStall);
}

// A closed clamp on both sides, 20 N/um.
TEST(UnseenMotion, AClampedAxisIsNoFault) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    PushedAxis axis(seed);
    const double here_m = axis.loop().plant.position_m();
    axis.loop().stops = sim::EndStops{
        .negative_m = here_m, .positive_m = here_m, .stiffness_N_per_m = 2e7, .damping_N_s_per_m = 2e4};
    axis.torque_mode();
    EXPECT_FALSE(axis.push(4.0, [](double t) { return 280.0 * std::sin(10.0 * t); })) << seed;
    EXPECT_FALSE(axis.push(1.0, [](double) { return 250.0; })) << seed;
    EXPECT_FALSE(axis.push(1.0, [](double) { return -250.0; })) << seed;
  }
}

// Twice the friction that the model has, and ten times that of others which the model knows: elastic before
// it slips.
TEST(UnseenMotion, ABigBreakawayForceIsNoFault) {
  const auto rougher = [](double factor) {
    return [factor](sim::Axis& axis) {
      std::vector<sim::CurveTerm> terms = axis.curve.terms();
      for (sim::CurveTerm& term : terms) term.level_N *= factor;
      axis.curve = sim::VirginCurve(terms);
    };
  };
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const bool known : {false, true}) {
      PushedAxis axis(seed, rougher(known ? 10.0 : 2.0), known);
      axis.torque_mode();
      const double friction_N = axis.friction_N();
      for (const double share : {0.3, 0.6, 0.95}) {
        EXPECT_FALSE(axis.push(0.7, [&](double) { return share * friction_N; })) << seed << " " << share;
        EXPECT_FALSE(axis.push(2.0, [&](double t) { return share * friction_N * std::cos(2.0 * t); }));
      }
      EXPECT_LT(std::abs(axis.velocity()), 0.05);
    }
  }
}

// So viscous that 250 N make 0.5 mm/s.
TEST(UnseenMotion, ASlowAxisIsNoFault) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    PushedAxis axis(seed,
                    [](sim::Axis& a) { a.effects.viscous = sim::Viscous{.coefficient_N_s_per_m = 5e5}; });
    axis.torque_mode();
    EXPECT_FALSE(axis.push(3.0, [](double) { return 250.0; })) << seed;
    EXPECT_GT(axis.velocity(), 2e-4);
  }
}

// A force that alternates so fast that the axis moves by less than a count.
TEST(UnseenMotion, AFastAlternatingForceIsNoFault) {
  for (const double frequency_Hz : {150.0, 500.0, 1500.0}) {
    PushedAxis axis(6);
    axis.torque_mode();
    EXPECT_FALSE(axis.push(4.0, [&](double t) { return 150.0 * std::sin(2.0 * M_PI * frequency_Hz * t); }))
        << frequency_Hz;
  }
}

// A step of the offset on an axis that holds its place: it is off by some micrometres until the integral has
// taken the force back.
TEST(UnseenMotion, AnOffsetIsNoFault) {
  PushedAxis axis(7);
  axis.controller().set_torque(0.0F, 60.0F);
  axis.run(3.0);
  EXPECT_EQ(axis.fault(), Fault::kNone);
  axis.controller().set_torque(0.0F, -60.0F);
  axis.run(3.0);
  EXPECT_EQ(axis.fault(), Fault::kNone);
}

// One count of it is 5 um: in a single tick that would be 50 mm/s.
TEST(UnseenMotion, ACoarseEncoderAtRestIsNoFault) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    PushedAxis axis(
        seed, [](sim::Axis& differs) { differs.encoder_resolution_m = 5e-6; }, true);
    axis.run(0.3);
    const std::int32_t home = axis.controller().reference().counts();
    for (const std::int32_t counts : {200, -4, 0}) {
      ASSERT_EQ(axis.controller().move_to(home + counts), PlanStatus::kOk);
      axis.run(0.5);
    }
    EXPECT_EQ(axis.fault(), Fault::kNone) << seed;
  }
}

}  // namespace
}  // namespace slipstack::loop
