// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/loop_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim_host/experiments/quasi_static.h"
#include "sim_host/rng.h"

namespace slipstack::workbench {
namespace {

/// Sines of displacement of stepped amplitude at several places, with noise on the force.
struct Record {
  std::vector<double> position_m;
  std::vector<double> force_N;
};

Record record(const std::vector<double>& places, const std::vector<double>& amplitudes, double noise_N,
              double noise_m) {
  const sim::VirginCurve curve({{sim::CurveKind::kRational, 10.0, 8e-6}});
  sim::Rng rng(4);
  Record result;
  for (const double place : places) {
    sim::MaxwellElements bank = sim::MaxwellElements::sample(curve, 200);
    bank.reset(place);
    for (const double A : amplitudes) {
      for (int i = 0; i < 12 * 400; ++i) {
        const double x = place + A * std::sin(2.0 * std::numbers::pi * (i + 1) / 400.0);
        bank.move_to(x);
        result.position_m.push_back(x + noise_m * rng.normal());
        result.force_N.push_back(bank.force_N() + noise_N * rng.normal());
      }
    }
  }
  return result;
}

TEST(LoopLog, FindsEveryAmplitudeAtEveryPlace) {
  const std::vector<double> places{0.010, 0.050, 0.090};
  const std::vector<double> amplitudes{2e-6, 5e-6, 12e-6, 30e-6};
  const Record log = record(places, amplitudes, 0.05, 10e-9);
  const auto loops = averaged_loops(log.position_m, log.force_N);
  ASSERT_EQ(loops.size(), places.size() * amplitudes.size());
  const RationalCurve curve{10.0, 8e-6};
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const double A = amplitudes[i % amplitudes.size()];
    EXPECT_NEAR(loops[i].position_m, places[i / amplitudes.size()], 0.02 * A);
    EXPECT_NEAR(loops[i].figures.amplitude_m, A, 0.01 * A + 40e-9);
    EXPECT_EQ(loops[i].count, 10u);
    const double exact = curve.closed_form(A).damping_ratio;
    EXPECT_NEAR(loops[i].figures.damping_ratio, exact, 0.05 * exact);
    EXPECT_LT(loops[i].damping_ratio_spread, 0.1 * exact);
    EXPECT_GT(loops[i].damping_ratio_spread, 0.0);
  }
}

TEST(LoopLog, AveragingLowersTheErrorOfNoise) {
  const Record log = record({0.0}, {10e-6}, 0.5, 0.0);
  const double exact = RationalCurve{10.0, 8e-6}.closed_form(10e-6).area_J;
  const double one = averaged_loops(log.position_m, log.force_N, 1).front().figures.area_J;
  const double ten = averaged_loops(log.position_m, log.force_N, 10).front().figures.area_J;
  EXPECT_LT(std::fabs(ten - exact), 0.01 * exact);
  EXPECT_LT(std::fabs(one - exact), 0.1 * exact);
}

TEST(LoopLog, TurningPointsIgnoreNoiseBelowTheThreshold) {
  sim::Rng rng(5);
  std::vector<double> x;
  for (int i = 0; i < 5000; ++i) {
    x.push_back(10.0 * std::sin(2.0 * std::numbers::pi * i / 1000.0) + 0.1 * rng.normal());
  }
  const double threshold = motion_threshold_m(x);
  EXPECT_GT(threshold, 0.6);
  EXPECT_LT(threshold, 1.1);
  // Ends and ten reversals.
  EXPECT_EQ(turning_points(x, threshold).size(), 12u);
  EXPECT_GT(turning_points(x, 0.0).size(), 100u);
}

TEST(LoopLog, RefusesARecordWithoutLoops) {
  std::vector<double> x(500);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1e-6 * static_cast<double>(i);
  EXPECT_THROW(averaged_loops(x, x), std::invalid_argument);
  EXPECT_THROW(averaged_loops(x, std::vector<double>(3)), std::invalid_argument);
}

TEST(QuasiStatic, ForceSinesDrawTheLoopsOfTheVirginCurve) {
  const sim::VirginCurve curve({{sim::CurveKind::kRational, 15.0, 12e-6}});
  sim::QuasiStaticTest test;
  test.frequency_Hz = 0.5;
  test.forces_N = sim::forces_for(curve, 2e-6, 30e-6, 4);
  const sim::QuasiStaticRecord log = sim::record_loops(sim::MaxwellElements::sample(curve, 200), test);
  const auto loops = averaged_loops(log.position_m, log.force_N);
  ASSERT_EQ(loops.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(loops[i].figures.force_N, test.forces_N[i], 2e-3 * test.forces_N[i]);
    const double A = 2e-6 * std::pow(15.0, static_cast<double>(i) / 3.0);
    EXPECT_NEAR(loops[i].figures.amplitude_m, A, 0.01 * A);
  }
}

TEST(QuasiStatic, RefusesAForceThatRollsAway) {
  const sim::MaxwellElements bank =
      sim::MaxwellElements::sample(sim::VirginCurve({{sim::CurveKind::kRational, 1.0, 1e-6}}), 50);
  EXPECT_THROW(sim::record_loops(bank, {.forces_N = {1.0}}), std::invalid_argument);
  EXPECT_THROW(sim::record_loops(bank, {.forces_N = {-0.5}}), std::invalid_argument);
  EXPECT_THROW(sim::record_loops(bank, {.frequency_Hz = 0.0, .forces_N = {0.5}}), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::workbench
