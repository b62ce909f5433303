// SPDX-License-Identifier: Apache-2.0
// Causes that machines have and the catalogue has not: a mass that depends on the place, a lubricant that
// warms or thins; and an axis whose log begins while its structure swings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

using test::diagnosed;

constexpr double kRateOfLog_Hz = 500.0;
constexpr double kMoved_kg = 10.0;

/// Sums of sines, and their derivatives.
struct Motion {
  double x = 0.0;
  double v = 0.0;
  double a = 0.0;
};
Motion motion_at(double t) {
  Motion motion;
  constexpr double kWaves[][3] = {{0.15, 0.6, 0.0}, {0.05, 2.3, 1.0}, {0.02, 5.1, 2.0}, {0.004, 11.0, 0.5}};
  for (const auto& [amplitude, rate, phase] : kWaves) {
    motion.x += amplitude * std::sin(rate * t + phase);
    motion.v += amplitude * rate * std::cos(rate * t + phase);
    motion.a -= amplitude * rate * rate * std::sin(rate * t + phase);
  }
  return motion;
}

/// A sine from 1 Hz at the start of 30 s to 5 Hz at their end: it passes the modes between.
Motion sweep_at(double t) {
  constexpr double kAmplitude_m = 0.002;
  const double phase = 2.0 * std::numbers::pi * (1.0 + t / 15.0) * t;
  const double rate = 2.0 * std::numbers::pi * (1.0 + 2.0 * t / 15.0);
  return {kAmplitude_m * std::sin(phase), kAmplitude_m * rate * std::cos(phase),
          kAmplitude_m * (4.0 * std::numbers::pi / 15.0 * std::cos(phase) - rate * rate * std::sin(phase))};
}

/// An axis with one stop operator of 4 N and the force of `more_N(time, motion)`.
template <class Force>
Log log_with(double seconds, Force&& more_N, Motion (*moves)(double) = motion_at) {
  constexpr double kLevel_N = 4.0;
  constexpr double kSlip_m = 20e-6;
  test::Draw draw(3);
  double last_m = moves(0.0).x;
  double deflection = 0.0;  // relative to its slip distance
  return test::log_of(
      kRateOfLog_Hz, static_cast<std::size_t>(seconds * kRateOfLog_Hz),
      [moves](double t) { return moves(t).x; },
      [&, more_N](double t) mutable {
        const Motion motion = moves(t);
        deflection = std::clamp(deflection + (motion.x - last_m) / kSlip_m, -1.0, 1.0);
        last_m = motion.x;
        return kMoved_kg * motion.a + kLevel_N * deflection + more_N(t, motion) + 0.02 * draw.normal();
      });
}

/// The number that follows `before` in a description.
double value_after(const Structure& structure, const std::string& before) {
  const std::size_t at = structure.description.find(before);
  return at == std::string::npos ? std::nan("") : std::stod(structure.description.substr(at + before.size()));
}

// A link whose inertia is (10 + 3 cos(8 x)) kg at x: torque by Lagrange, with the force of its change.
TEST(MachineCauses, AMassThatDependsOnThePlaceIsToldWithWhatItChanges) {
  const Log log = log_with(40.0, [](double, const Motion& m) {
    return 3.0 * std::cos(8.0 * m.x) * m.a - 0.5 * 3.0 * 8.0 * std::sin(8.0 * m.x) * m.v * m.v;
  });
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::unexplained) << is.steps.back().effect;
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::position);
  EXPECT_NE(is.unexplained->description.find("the mass depends on the position"), std::string::npos)
      << is.unexplained->description;
  const double farthest_m = *std::max_element(log.position_m.begin(), log.position_m.end());
  const double change_kg = 3.0 * (1.0 - std::cos(8.0 * farthest_m));
  EXPECT_NEAR(value_after(*is.unexplained, "more by "), change_kg, 0.1 * change_kg)
      << is.unexplained->description;
  EXPECT_LT(is.unexplained->error_reduction, 1.0);
  EXPECT_GT(is.unexplained->error_reduction, 0.8);
}

// The viscous friction falls as the lubricant warms, the dry friction does not: no friction level drifts.
TEST(MachineCauses, ALubricantThatWarmsIsNoDriftOfTheFrictionLevel) {
  const Log log =
      log_with(60.0, [](double t, const Motion& m) { return (12.0 + 12.0 * std::exp(-t / 20.0)) * m.v; });
  const Diagnosis is = diagnosed(log);
  ASSERT_EQ(is.steps.size(), 2u) << is.steps.back().effect;
  EXPECT_EQ(is.steps[1].effect, "viscous");
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::time) << is.unexplained->description;
  // From where the log no longer depends on how it began.
  const double from_s = Measurement(log).burn_in_s();
  EXPECT_NEAR(from_s, 4.0, 0.1);
  EXPECT_NEAR(value_after(*is.unexplained, "during the log, by "),
              12.0 * (std::exp(-60.0 / 20.0) - std::exp(-from_s / 20.0)), 0.5)
      << is.unexplained->description;
}

// Shear thinning by a power law: the viscous friction keeps its name, and the rest is told as what it is.
TEST(MachineCauses, ALubricantThatThinsIsToldBesideViscousFriction) {
  const Log log = log_with(
      40.0, [](double, const Motion& m) { return std::copysign(20.0 * std::pow(std::abs(m.v), 0.6), m.v); });
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_GE(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "viscous");
  ASSERT_TRUE(is.unexplained);
  EXPECT_EQ(is.unexplained->coordinate, Coordinate::velocity) << is.unexplained->description;
  EXPECT_NEAR(value_after(*is.unexplained, "a power of the velocity, "), 0.6, 0.05)
      << is.unexplained->description;
}

// A true viscous friction is not told as one that thins or warms.
TEST(MachineCauses, AViscousFrictionHasNoSuchCause) {
  const Diagnosis is = diagnosed(log_with(40.0, [](double, const Motion& m) { return 20.0 * m.v; }));
  ASSERT_EQ(is.steps.size(), 2u) << is.steps.back().effect;
  EXPECT_EQ(is.steps[1].effect, "viscous");
  EXPECT_FALSE(is.unexplained) << is.unexplained->description;
  EXPECT_TRUE(is.outside.causes.empty());
}

// A log that begins while a mode of 4 Hz rings with 6 N, which decay by e in 0.8 s.
TEST(MachineCauses, AModeThatRingsWhenTheLogBeginsKeepsItsName) {
  constexpr double kFrequency_Hz = 4.0;
  constexpr double kDamping = 0.05;
  constexpr double kModal_kg = 3.0;
  const double omega = 2.0 * std::numbers::pi * kFrequency_Hz;
  double q_mps2 = 2.0;  // omega^2 times the deflection; at rest it is the acceleration
  double rate_mps2 = 0.0;
  double last_s = 0.0;
  const Log log = log_with(
      30.0,
      [&](double t, const Motion& m) mutable {
        constexpr int kSteps = 20;
        for (int i = 0; i < kSteps && t > last_s; ++i) {
          const double dt = (t - last_s) / kSteps;
          rate_mps2 += dt * omega * (m.a - q_mps2 - 2.0 * kDamping * rate_mps2);
          q_mps2 += dt * omega * rate_mps2;
        }
        last_s = t;
        return kModal_kg * (q_mps2 + 2.0 * kDamping * rate_mps2);
      },
      sweep_at);
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::missing_effect) << is.unexplained->description;
  ASSERT_EQ(is.steps.size(), 2u) << is.steps.back().effect;
  EXPECT_EQ(is.steps[1].effect, "structural_resonance");
  EXPECT_FALSE(is.unexplained) << is.unexplained->description;
}

}  // namespace
}  // namespace slipstack::workbench
