// SPDX-License-Identifier: Apache-2.0
// The Runge-Kutta path: its order, its agreement with the exact path and with inverse dynamics.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sim_host/log/draw.h"
#include "sim_host/plant/exact_axis.h"
#include "sim_host/plant/plant.h"
#include "sim_host/plant/prescribed_axis.h"

namespace slipstack::sim {
namespace {

Axis simple_axis(std::size_t elements) {
  Axis axis;
  axis.mass_kg = 5.0;
  axis.curve = VirginCurve({{CurveKind::kExponential, 10.0, 8e-6, 1.0}});
  axis.elements = elements;
  axis.motor_constant_N_per_A = 1.0;
  axis.current_limit_A = 1e3;
  return axis;
}

// Error of the place after pushes through pre-sliding, sliding and reversals, against the exact path; root
// mean square over eight masses, so that no lucky coincidence of a step with an event decides.
double error_m(double step_times_rate, bool locate_slips) {
  Plant::Options options;
  options.step_times_rate = step_times_rate;
  options.locate_slips = locate_slips;
  double squares = 0.0;
  for (int trial = 0; trial < 8; ++trial) {
    Axis axis = simple_axis(12);
    axis.mass_kg = 5.0 + 0.7 * trial;
    Plant plant(axis, 0.0, options);
    LinearPart linear;
    linear.mass_kg = axis.mass_kg;
    ExactAxis exact(linear, MaxwellElements::sample(axis.curve, axis.elements));
    double t_s = 0.0;
    for (const double push_N : {7.0, -6.0, 9.0, -8.0, 4.0, 0.0, 6.0, -7.0, 8.0, 0.0}) {
      t_s += 0.011;
      plant.step(push_N, 0.011);
      exact.set_force({push_N});
      exact.advance_to(t_s);
    }
    EXPECT_GT(exact.reversals(), 6U);
    squares += std::pow(plant.position_m() - exact.position_m(), 2);
  }
  return std::sqrt(squares / 8.0);
}

double order(double coarse_step, double fine_step, bool locate_slips) {
  const double ratio = error_m(coarse_step, locate_slips) / error_m(fine_step, locate_slips);
  return std::log(ratio) / std::log(coarse_step / fine_step);
}

// Measured when written: 4.01, 3.95, 3.97 on halving the step from 1/32 to 1/256 rad.
TEST(Plant, ConvergesWithTheFourthOrderWhenEventsAreLocated) {
  const double measured = order(1.0 / 32.0, 1.0 / 256.0, true);
  EXPECT_GT(measured, 3.8);
  EXPECT_LT(measured, 4.2);
  EXPECT_LT(error_m(1.0 / 256.0, true), 1e-15);
}

TEST(Plant, ConvergesWithTheSecondOrderAcrossUnlocatedSlips) {
  const double measured = order(1.0, 1.0 / 256.0, false);
  EXPECT_GT(measured, 1.6);
  EXPECT_LT(measured, 2.4);
}

TEST(Plant, FollowsTheExactPathWithArmAndViscousFriction) {
  Axis axis = simple_axis(200);
  axis.effects.viscous = Viscous{20.0, 1.0};
  axis.effects.resonance = Resonance{0.25, 2.0 * std::numbers::pi * 25.0, 0.03};
  Plant::Options options;
  options.locate_slips = true;
  options.step_times_rate = 0.05;
  Plant plant(axis, 0.0, options);
  LinearPart linear;
  linear.mass_kg = axis.mass_kg;
  linear.viscous_N_s_per_m = 20.0;
  linear.arm_ratio = 0.25;
  linear.arm_rad_per_s = 2.0 * std::numbers::pi * 25.0;
  linear.arm_damping_ratio = 0.03;
  ExactAxis exact(linear, MaxwellElements::sample(axis.curve, 200));
  Rng rng(2);
  for (int i = 1; i <= 50; ++i) {
    const double force_N = 12.0 * rng.uniform(-1.0, 1.0);
    plant.step(force_N, 0.01);
    exact.set_force({force_N});
    exact.advance_to(0.01 * i);
    ASSERT_NEAR(plant.position_m(), exact.position_m(), 2e-10) << i;
  }
}

// Everything at once: the parts of the force add up to the force that drives.
TEST(Plant, PartsAddUpToTheDrive) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Bench bench = draw_bench(Setup::kRandom, seed);
    bench.programme.seconds = 8.0;
    const MotionProgramme programme = draw_programme(bench, seed);
    Axis axis = bench.axis;
    add_effects(axis, drawable_effects(), programme, 1000.0, 2.0, seed);
    add_outside(axis, seed % 2 == 0 ? OutsideKind::kBacklash : OutsideKind::kBump, programme, 1000.0, 2.0,
                seed);
    Plant plant(axis, 0.5 * axis.stroke_m);
    Rng rng(seed);
    double current_A = 0.0;
    for (int i = 0; i < 3000; ++i) {
      if (i % 100 == 0)
        current_A = 3.0 * axis.curve.saturation_N() / axis.motor_constant_N_per_A * rng.uniform(-1.0, 1.0);
      const double noise_N = axis.force_noise_N * rng.normal();
      plant.step(current_A, 1e-4, noise_N);
      double sum_N = 0.0;
      for (const double part : plant.parts(current_A, noise_N)) sum_N += part;
      const double drive_N = plant.command_N(current_A) + noise_N;
      ASSERT_NEAR(sum_N, drive_N, 1e-9 * (1.0 + std::fabs(drive_N))) << "seed " << seed << " tick " << i;
    }
  }
}

TEST(Loads, ForwardUndoesInverse) {
  Rng rng(4);
  for (const AccelerationLaw law :
       {AccelerationLaw::kProportional, AccelerationLaw::kSmooth, AccelerationLaw::kSaturating}) {
    Axis axis = simple_axis(20);
    axis.effects.acceleration = AccelerationPreload{law, 0.05, 2.0};
    axis.effects.motor_ripple = Ripple{0.02, {{1, 0.03, 0.4}}};
    for (int i = 0; i < 2000; ++i) {
      const Loads loads = loads_on(axis, axis.mass_kg, 0.0, rng.uniform(0.0, 0.3), rng.normal(),
                                   10.0 * rng.uniform(-1.0, 1.0), 0.0, {});
      const double a = 10.0 * rng.normal();
      EXPECT_NEAR(acceleration_mps2(axis, loads, drive_force_N(axis, loads, a)), a, 1e-10);
    }
  }
}

// The friction turns where the motion turns, not at the next sample: coarse and fine sampling agree.
TEST(PrescribedAxis, FrictionTurnsBetweenTheSamples) {
  const Axis axis = simple_axis(200);
  MotionProgramme programme;
  programme.append(make_sine(0.1, 12e-6, 3.0, 5));
  PrescribedAxis coarse(axis, programme);
  PrescribedAxis fine(axis, programme);
  for (int i = 1; i <= 50; ++i) {
    const double t_s = 0.031 * i;
    coarse.advance_to(t_s);
    for (int j = 1; j <= 100; ++j) fine.advance_to(0.031 * (i - 1) + 0.00031 * j);
    fine.advance_to(t_s);
    ASSERT_NEAR(coarse.parts()[index(EffectId::kPreslidingHysteresis)],
                fine.parts()[index(EffectId::kPreslidingHysteresis)], 1e-9)
        << i;
  }
}

// Driven by the force that inverse dynamics asked for, the axis makes the motion (for as long as an open loop
// can).
TEST(Plant, MakesTheMotionThatInverseDynamicsWasAskedFor) {
  Axis axis = simple_axis(200);
  axis.effects.viscous = Viscous{300.0, 1.0};
  axis.effects.stribeck = WeakeningCurve{WeakeningKind::kGaussian, 0.3, 0.02, 1.0};
  axis.effects.ripple = Ripple{0.03, {{1, 1.0, 0.5}}};
  axis.effects.cable = CableChain{400.0, 0.1, 0.0, 0.3};
  axis.effects.lag =
      FrictionalLag{LagKind::kTime, {WeakeningKind::kTustin, 0.2, 0.02, 1.0}, 0.05, 1e-3, 50.0};
  MotionProgramme programme;
  programme.append(make_sine(0.1, 0.004, 4.0, 4));
  PrescribedAxis inverse(axis, programme);
  Plant plant(axis, 0.1);
  constexpr double kTick = 1e-5;
  double worst = 0.0;
  for (int i = 0; i < 50000; ++i) {
    inverse.advance_to((i + 0.5) * kTick);
    double force_N = 0.0;
    for (const double part : inverse.parts()) force_N += part;
    plant.step(force_N, kTick);
    worst = std::max(worst, std::fabs(plant.position_m() - programme.at((i + 1) * kTick).x_m));
  }
  EXPECT_LT(worst, 4e-6);  // a thousandth of the amplitude
}

TEST(Plant, BacklashHoldsTheCarriageUntilTheGapIsCrossed) {
  Axis axis = simple_axis(200);
  axis.outside.backlash = Backlash{50e-6, 0.2, 1000.0, 0.4};
  Plant plant(axis, 0.0);
  plant.step(20.0, 0.05);  // pushes the carriage along
  const double lead_m = plant.position_m() - plant.carriage_position_m();
  EXPECT_GT(lead_m, 25e-6);
  EXPECT_LT(lead_m, 80e-6);
}

TEST(Plant, CurrentIsLimited) {
  Axis axis = simple_axis(20);
  axis.current_limit_A = 2.0;
  const Plant plant(axis);
  EXPECT_EQ(plant.command_N(5.0), 2.0);
  EXPECT_EQ(plant.command_N(-5.0), -2.0);
}

TEST(Plant, RefusesWhatIsNotPhysical) {
  Axis axis = simple_axis(20);
  axis.mass_kg = -1.0;
  EXPECT_THROW(Plant{axis}, std::invalid_argument);
  axis = simple_axis(20);
  axis.effects.resonance = Resonance{1.2, 100.0, 0.1};
  EXPECT_THROW(Plant{axis}, std::invalid_argument);
  Plant plant(simple_axis(20));
  EXPECT_THROW(plant.step(1.0, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::sim
