// SPDX-License-Identifier: Apache-2.0
// The describing function against closed forms, and against the simulated response.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_host/experiments/describing_function.h"
#include "sim_host/experiments/stepped_sine.h"

namespace slipstack::sim {
namespace {

constexpr double kPi = std::numbers::pi;

// [2], for y = h₀(1 − (δ/(x + δ))²).
TEST(DescribingFunction, MeetsTheClosedFormsOfTheRationalCurve) {
  const double h0 = 2.0;
  const double delta = 2.0e-6;
  const VirginCurve curve({{CurveKind::kRational, h0, delta, 1.0}});
  for (const double a : {1e-9, 1e-8, 1e-7, 1e-6, 2e-6, 1e-5, 1e-4, 1e-3}) {
    const Equivalent found = equivalent(curve, a);
    const double tip = h0 / a * (1.0 - std::pow(delta / (a + delta), 2));
    const double damping = 4.0 * h0 * a / (kPi * std::pow(a + delta, 2));
    const double ratio = 2.0 / kPi * a / (a + 2.0 * delta);
    EXPECT_NEAR(found.tip_stiffness_N_per_m, tip, 1e-9 * tip) << a;
    EXPECT_NEAR(found.damping_N_per_m, damping, 1e-6 * tip) << a;
    EXPECT_NEAR(found.resonance_damping_ratio, ratio, 1e-6 + 1e-7 * ratio) << a;
  }
}

// A single Maxwell element: Fourier coefficients of the elasto-plastic loop in closed form.
TEST(DescribingFunction, MeetsTheClosedFormOfOneElement) {
  CurveTerm term;
  term.kind = CurveKind::kPoints;
  term.points_m = {1e-6};
  term.points_N = {3.0};
  term.level_N = 3.0;
  term.length_m = 1e-6;
  const VirginCurve curve({term});
  for (const double a : {0.5e-6, 1.5e-6, 4e-6}) {
    const Equivalent found = equivalent(curve, a);
    const double k = 3e6;
    double stiffness = k;
    double damping = 0.0;
    if (a > 1e-6) {
      const double theta = std::acos(1.0 - 2.0 * 1e-6 / a);
      stiffness = k / kPi * (theta - 0.5 * std::sin(2.0 * theta));
      damping = 4.0 * k * 1e-6 * (a - 1e-6) / (kPi * a * a);
    }
    EXPECT_NEAR(found.stiffness_N_per_m, stiffness, 2e-4 * k) << a;
    EXPECT_NEAR(found.damping_N_per_m, damping, 2e-4 * k) << a;
  }
}

// For y = xⁿ: ζᵣ is constant, (2/π)(1 − n)/(1 + n) from its definition.
TEST(DescribingFunction, GivesAPowerLawAConstantDampingRatio) {
  for (const double n : {0.3, 0.5, 0.8}) {
    // Far below its length a stretched exponential is a power law.
    const VirginCurve curve({{CurveKind::kStretched, 1.0, 1.0, n}});
    for (const double a : {1e-12, 1e-10}) {
      const double expected = 2.0 / kPi * (1.0 - n) / (1.0 + n);
      EXPECT_NEAR(equivalent(curve, a).resonance_damping_ratio, expected, 0.01 * expected) << n << ' ' << a;
    }
  }
}

double error_of(const DescribedPoint& described, const SinePoint& simulated) {
  const auto a = std::polar(described.amplitude_m, described.phase_rad);
  const auto b = std::polar(simulated.amplitude_m, simulated.phase_rad);
  return std::abs(a - b) / std::abs(b);
}

// [1]: accurate away from saturation, least accurate in the sensitive region.
TEST(DescribingFunction, IsAccurateAwayFromSaturationAndWorstAtIt) {
  const ExperimentSetup setup = read_setup("pick_and_place");
  const double level_N = setup.axis.curve.saturation_N();
  SteppedSineRequest request;
  request.forces_N = {0.02 * level_N, 0.3 * level_N, 1.06 * level_N, 4.0 * level_N, 20.0 * level_N};
  request.frequencies_Hz = log_frequencies(1.0, 100.0, 20);
  request.most_periods = 1000;
  std::vector<SweepChain> chains;
  run_stepped_sine(setup, request, chains);
  std::vector<double> median;
  for (const SweepChain& chain : chains) {
    std::vector<double> errors;
    for (const SinePoint& point : chain.sweeps[0].points) {
      const DescribedPoint described = describe_response(setup, chain.force_N, point.frequency_Hz);
      if (described.solutions > 0) errors.push_back(error_of(described, point));
    }
    ASSERT_GT(errors.size(), 15U) << chain.force_N;
    std::sort(errors.begin(), errors.end());
    median.push_back(errors[errors.size() / 2]);
  }
  EXPECT_LT(median[0], 2e-3);
  EXPECT_LT(median[1], 2e-2);
  EXPECT_GT(median[2], 0.1);
  EXPECT_LT(median[2], 1.0);
  EXPECT_LT(median[3], 0.3 * median[2]);
  EXPECT_LT(median[4], 5e-3);
}

}  // namespace
}  // namespace slipstack::sim
