// SPDX-License-Identifier: Apache-2.0
// The high-order path: its order, and its agreement with the event-exact path and with the tick-by-tick
// plant.
#include <gtest/gtest.h>

#include <cmath>

#include "sim_host/experiments/exact_parts.h"
#include "sim_host/plant/plant.h"
#include "sim_host/plant/smooth_axis.h"
#include "sim_host/rng.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

double place_after(double tolerance, double fixed_step_s, double mass_kg) {
  Axis axis;
  axis.mass_kg = mass_kg;
  axis.curve = VirginCurve({{CurveKind::kExponential, 10.0, 8e-6, 1.0}});
  axis.motor_constant_N_per_A = 1.0;
  axis.current_limit_A = 1e3;
  SmoothAxis smooth(axis, 0.0, {tolerance, fixed_step_s});
  double t_s = 0.0;
  for (const double push_N : {7.0, -6.0, 9.0, -8.0, 4.0, 0.0, 6.0, -7.0, 8.0, 0.0}) {
    smooth.set_force({push_N, 0.0, 0.0, 0.0});
    t_s += 0.011;
    smooth.advance_to(t_s);
  }
  EXPECT_GT(smooth.reversals(), 6U);
  return smooth.position_m();
}

double rms_error_m(double fixed_step_s) {
  double squares = 0.0;
  for (int trial = 0; trial < 8; ++trial) {
    const double mass_kg = 5.0 + 0.7 * trial;
    squares += std::pow(place_after(1e-8, fixed_step_s, mass_kg) - place_after(1e-13, 0.0, mass_kg), 2);
  }
  return std::sqrt(squares / 8.0);
}

TEST(SmoothAxis, ConvergesWithTheFifthOrder) {
  const double coarse = rms_error_m(4e-4);
  const double fine = rms_error_m(1e-4);
  const double order = std::log(coarse / fine) / std::log(4.0);
  EXPECT_GT(order, 4.6);
  EXPECT_LT(order, 5.6);
  EXPECT_LT(fine, 1e-14);
}

// The elements are straight lines through the curve's points: doubling their number quarters the difference.
TEST(SmoothAxis, IsWhatTheExactPathBecomesWithManyElements) {
  ExperimentSetup setup = read_setup("slideway");
  const double w = kTurn * 250.0;
  SmoothAxis smooth(setup.axis, 0.0, {1e-11, 0.0});
  smooth.set_force({0.0, 4.0, w, 0.0});
  smooth.advance_to(0.02);
  double last = 0.0;
  for (const std::size_t elements : {100U, 400U, 1600U}) {
    setup.axis.elements = elements;
    ExactAxis exact(linear_part(setup, "test"), maxwell_elements(setup));
    exact.set_force({0.0, 4.0, w, 0.0});
    exact.advance_to(0.02);
    const double difference = std::fabs(exact.position_m() - smooth.position_m()) / 1e-6;
    if (last > 0.0) {
      EXPECT_LT(difference, 0.2 * last) << elements;
    }
    last = difference;
  }
  EXPECT_LT(last, 1e-4);
  EXPECT_GT(last, 1e-9);
}

TEST(SmoothAxis, FollowsTheExactPathWithArmViscousFrictionAndCable) {
  ExperimentSetup setup = parse_setup(
      "based_on = \"pick_and_place\"\nelements = 3000\n[arm]\nmass_ratio = 0.25\nfrequency_Hz = 25.0\n"
      "damping_ratio = 0.03\n[viscous]\ncoefficient_N_s_per_m = 40.0\n[cable_chain]\nstiffness_N_per_m = "
      "5000.0\n",
      "test");
  setup.position_m = 0.0;
  setup.axis.effects.cable->rest_m = 1e-5;
  SmoothAxis smooth(setup.axis, 0.0, {1e-11, 0.0});
  ExactAxis exact(linear_part(setup, "test"), maxwell_elements(setup));
  Rng rng(2);
  for (int i = 1; i <= 40; ++i) {
    const SineForce force = {3.0 * rng.uniform(-1.0, 1.0), 12.0 * rng.uniform(),
                             kTurn * rng.uniform(2.0, 40.0), 0.0};
    smooth.set_force(force);
    SineForce absolute = force;
    absolute.phase_rad = -force.rad_per_s * exact.time_s();
    exact.set_force(absolute);
    smooth.advance_to(0.01 * i);
    exact.advance_to(0.01 * i);
    ASSERT_NEAR(smooth.position_m(), exact.position_m(), 3e-8) << i;
  }
}

// Every effect of the catalogue, one at a time and all together, against the tick-by-tick plant with fine
// steps.
class EveryEffect : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryEffect, ActsAsInTheTickByTickPlant) {
  const ExperimentSetup setup =
      parse_setup(std::string("based_on = \"pick_and_place\"\nelements = 2000\n") + GetParam(), "test");
  Plant plant(setup.axis, setup.position_m, {true, 0.05});
  SmoothAxis smooth(setup.axis, setup.position_m, {1e-10, 0.0});
  SmoothAxis bare(read_setup("pick_and_place").axis, setup.position_m, {1e-10, 0.0});
  Rng rng(5);
  double differs_m = 0.0;
  for (int i = 1; i <= 16; ++i) {
    const double push_N = 25.0 * rng.uniform(-1.0, 1.0);
    plant.step(push_N / setup.axis.motor_constant_N_per_A, 0.01);
    for (SmoothAxis* axis : {&smooth, &bare}) {
      axis->set_force({push_N, 0.0, 0.0, 0.0});
      axis->advance_to(0.01 * i);
    }
    ASSERT_NEAR(smooth.position_m(), plant.position_m(), 2e-7) << "push " << i;
    differs_m = std::max(differs_m, std::fabs(smooth.position_m() - bare.position_m()));
  }
  EXPECT_GT(differs_m, 1e-6) << "the effect does nothing";
}

constexpr const char* kEffects[] = {
    "[coulomb]\nlevel_N = 1.0\nslip_m = 1e-6",
    "[viscous]\ncoefficient_N_s_per_m = 60.0\nexponent = 0.8",
    "[quadratic_drag]\ncoefficient = 30000.0",
    "[stribeck]\nkind = \"tustin\"\ndepth = 0.3\nvelocity_mps = 0.01",
    "[frictional_lag]\nlag = \"attraction\"\nkind = \"gaussian\"\ndepth = 0.3\nvelocity_mps = 0.01\n"
    "attraction_per_s = 50.0",
    "[preload_map]\nkind = \"sines\"\ndepth = 0.1\namplitude = [1.0]\nlength_m = [1e-3]\nphase_rad = [0.4]",
    "[acceleration_dependent_preload]\nlaw = \"smooth\"\ngain_s2_per_m = 0.3",
    "[direction_asymmetry]\nlaw = \"by_force\"\nlevel = 0.1",
    "[cogging]\namplitude_N = [2.0, 0.5]\nphase_rad = [0.3, 1.0]",
    "[force_constant_ripple]\namplitude = [0.03]\nphase_rad = [0.3]",
    "offset_N = 2.0",
    "[cable_chain]\nstiffness_N_per_m = 4000.0\nstiffening = 0.5",
    "added_mass_kg = 5.0",
    "[arm]\nmass_ratio = 0.2\nfrequency_Hz = 30.0\ndamping_ratio = 0.02",
    "[drift]\nkind = \"warming\"\ntarget = \"hysteresis\"\ndepth = -0.3\ntime_s = 0.1",
    "[drive]\ncurrent_loop_Hz = 60.0",
};
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(kEffects));

TEST(SmoothAxis, GoesOnFromASnapshotBitForBit) {
  const ExperimentSetup setup = parse_setup(
      "based_on = \"pick_and_place_rail\"\n[arm]\nmass_ratio = 0.2\nfrequency_Hz = 30.0\ndamping_ratio = "
      "0.02\n[coulomb]\nlevel_N = 1.0\nslip_m = 1e-6",
      "test");
  SmoothAxis one(setup.axis, 0.2);
  one.set_force({0.0, 12.5, kTurn * 3.0, 0.0});
  one.advance_to(1.0);
  SmoothAxis other(setup.axis, 0.2);
  other.restore(one.snapshot());
  for (SmoothAxis* axis : {&one, &other}) {
    axis->set_force({0.0, 11.0, kTurn * 4.0, 0.0});
    axis->advance_to(2.0);
  }
  EXPECT_EQ(one.position_m(), other.position_m());
  EXPECT_EQ(one.snapshot(), other.snapshot());
}

}  // namespace
}  // namespace slipstack::sim
