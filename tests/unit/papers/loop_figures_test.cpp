// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/loop_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim_host/plant/friction/maxwell_elements.h"

// Figures of loops against the closed forms of [2], of a linear system, and of single elements.
namespace slipstack::workbench {
namespace {

using std::numbers::pi;

/// F = k·x + c·ω·x′/ω on an ellipse: the linear system whose figures are known.
Loop ellipse(double stiffness, double damping, double amplitude_m, double offset_N, std::size_t count) {
  Loop loop;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 2.0 * pi * static_cast<double>(i) / static_cast<double>(count);
    loop.position_m.push_back(amplitude_m * std::sin(t));
    loop.force_N.push_back(offset_N + stiffness * amplitude_m * std::sin(t) +
                           damping * amplitude_m * std::cos(t));
  }
  return loop;
}

/// The steady loop that a bank of elements draws under a sine of displacement.
Loop drawn(sim::MaxwellElements bank, double amplitude_m, std::size_t count) {
  Loop loop;
  for (std::size_t cycle = 0; cycle < 3; ++cycle) {
    for (std::size_t i = 0; i < count; ++i) {
      const double x =
          -amplitude_m * std::cos(2.0 * pi * static_cast<double>(i) / static_cast<double>(count));
      bank.move_to(x);
      if (cycle < 2) continue;
      loop.position_m.push_back(x);
      loop.force_N.push_back(bank.force_N());
    }
  }
  return loop;
}

TEST(LoopFigures, OfALinearSystemAreItsOwn) {
  const LoopFigures figures = figures_of(ellipse(2000.0, 120.0, 5e-6, 0.3, 4000));
  EXPECT_NEAR(figures.amplitude_m, 5e-6, 1e-12);
  EXPECT_NEAR(figures.fundamental_stiffness_N_per_m, 2000.0, 0.2);
  EXPECT_NEAR(figures.stiffness_N_per_m, 2000.0, 0.2);
  EXPECT_NEAR(figures.damping_N_per_m, 120.0, 1e-3);
  // ζ = c·ω/(2k) at resonance.
  EXPECT_NEAR(figures.damping_ratio, 120.0 / 4000.0, 1e-5);
}

TEST(LoopFigures, ClosedFormsOfTheRationalCurveAreTheQuadrature) {
  // [2], Fig. 6: δ = 2, h₀ = 2.
  const RationalCurve curve{2.0, 2.0};
  for (const double A : {0.01, 0.1, 1.0, 2.0, 10.0, 100.0}) {
    const LoopFigures exact = curve.closed_form(A);
    const LoopFigures found = figures_of_virgin([&](double x) { return curve.force_N(x); }, A);
    EXPECT_NEAR(found.stiffness_N_per_m, exact.stiffness_N_per_m, 1e-12 * exact.stiffness_N_per_m);
    EXPECT_NEAR(found.area_J, exact.area_J, 1e-8 * exact.area_J + 1e-12 * A * found.force_N);
    EXPECT_NEAR(found.damping_ratio, exact.damping_ratio, 1e-7);
    EXPECT_NEAR(found.damping_N_per_m, exact.damping_N_per_m, 1e-7 * curve.initial_stiffness_N_per_m());
  }
  // Limits that the paper states: no damping at first, 2/π at last.
  EXPECT_LT(curve.closed_form(1e-6).damping_ratio, 1e-6);
  EXPECT_NEAR(curve.closed_form(1e9).damping_ratio, 2.0 / pi, 1e-6);
}

TEST(LoopFigures, OfAPowerLawAreTheSameAtEveryAmplitude) {
  for (const double exponent : {0.3, 0.5, 0.8}) {
    const double expected = 2.0 / pi * (1.0 - exponent) / (1.0 + exponent);
    EXPECT_DOUBLE_EQ(power_law_damping_ratio(exponent), expected);
    for (const double A : {1e-3, 1.0, 50.0}) {
      const auto curve = [&](double x) { return std::pow(x, exponent); };
      EXPECT_NEAR(figures_of_virgin(curve, A).damping_ratio, expected, 1e-5);
    }
    // What the text prints is larger by π/2; the integral decides against it.
    EXPECT_GT((1.0 - exponent) / (1.0 + exponent), 1.5 * expected);
  }
}

TEST(LoopFigures, OfADrawnLoopAreThoseOfItsVirginCurve) {
  const sim::VirginCurve curve({{sim::CurveKind::kRational, 15.0, 12e-6}});
  const sim::MaxwellElements bank = sim::MaxwellElements::sample(curve, 400);
  const RationalCurve same{15.0, 12e-6};
  for (const double A : {2e-6, 10e-6, 40e-6}) {
    const LoopFigures found = figures_of(drawn(bank, A, 2000));
    const LoopFigures exact = same.closed_form(A);
    EXPECT_NEAR(found.damping_ratio, exact.damping_ratio, 2e-3 * exact.damping_ratio);
    EXPECT_NEAR(found.stiffness_N_per_m, exact.stiffness_N_per_m, 1e-3 * exact.stiffness_N_per_m);
    const LoopFigures virgin = figures_of_virgin([&](double x) { return curve.force_N(x); }, A);
    EXPECT_NEAR(found.fundamental_stiffness_N_per_m, virgin.fundamental_stiffness_N_per_m,
                2e-3 * virgin.fundamental_stiffness_N_per_m);
    // The major axis is an approximation of the fundamental, and a good one.
    EXPECT_LT(virgin.fundamental_stiffness_N_per_m, virgin.stiffness_N_per_m);
    EXPECT_GT(virgin.fundamental_stiffness_N_per_m, 0.75 * virgin.stiffness_N_per_m);
  }
}

TEST(LoopFigures, OfOneElementAreAParallelogram) {
  const double k = 1e5;
  const double slip = 2e-6;
  const double A = 10e-6;
  const LoopFigures figures = figures_of(drawn(sim::MaxwellElements({k}, {slip}), A, 20000));
  EXPECT_NEAR(figures.area_J, 4.0 * k * slip * (A - slip), 1e-4 * figures.area_J);
  EXPECT_NEAR(figures.force_N, k * slip, 1e-12);
}

TEST(LoopFigures, RefuseWhatIsNoLoop) {
  EXPECT_THROW(figures_of({{0.0, 1.0}, {0.0, 1.0}}), std::invalid_argument);
  Loop backwards = ellipse(2000.0, -120.0, 5e-6, 0.0, 100);
  EXPECT_THROW(figures_of(backwards), std::invalid_argument);
  EXPECT_THROW(figures_of(ellipse(-2000.0, 120.0, 5e-6, 0.0, 100)), std::invalid_argument);
  EXPECT_THROW(figures_of_virgin([](double x) { return x; }, 0.0), std::invalid_argument);
}

// The amplitude may lie below the first corner of a fitted polygon.
TEST(LoopFigures, OfAStraightLineHaveNoDamping) {
  for (const double stiffness : {0.1, 1.0 / 3.0, 7.0e5, 39816.3}) {
    const LoopFigures figures = figures_of(ellipse(stiffness, 0.0, 11.4e-6, 0.0, 2000));
    EXPECT_LT(figures.damping_ratio, 1e-13);
    EXPECT_GE(figures.damping_ratio, 0.0);
    EXPECT_NEAR(figures.stiffness_N_per_m, stiffness, 1e-9 * stiffness);
  }
}

}  // namespace
}  // namespace slipstack::workbench
