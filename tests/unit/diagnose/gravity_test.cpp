// SPDX-License-Identifier: Apache-2.0
// Gravity of a link over less than half a turn: a sine of one turn, and no line with a bend.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "workbench/base/axis_units.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// A joint that moves over about 2.6 rad in a motion that does not repeat, with dry friction that develops
/// within 5 mrad, viscous friction of 6 N m s/rad and a torque over its angle.
template <class Torque>
Log joint(Torque&& torque_Nm) {
  constexpr double kInertia_kgm2 = 1.5;
  test::Draw draw(7);
  const auto angle = [](double t) {
    return 0.7 * std::sin(1.1 * t) + 0.4 * std::sin(2.9 * t + 1.0) + 0.2 * std::sin(4.3 * t + 2.0);
  };
  double deflection = 0.0;
  double before = angle(0.0);
  Log log = test::log_of(500.0, 20000, angle, [&](double t) {
    const double q = angle(t);
    deflection = std::clamp(deflection + q - before, -5e-3, 5e-3);
    before = q;
    const double rate = (angle(t + 1e-4) - angle(t - 1e-4)) / 2e-4;
    const double acceleration = (angle(t + 1e-3) - 2.0 * q + angle(t - 1e-3)) / 1e-6;
    return kInertia_kgm2 * acceleration + 4.0 * deflection / 5e-3 + 6.0 * rate + torque_Nm(q) +
           0.05 * draw.normal();
  });
  log.mass_kg = kInertia_kgm2;
  return log;
}

double gravity_Nm(double q) {
  return 20.0 * std::sin(q + 0.4);
}

class OnARotaryAxis : public ::testing::Test {
 protected:
  void SetUp() override { use_axis({AxisKind::rotary, AngleUnit::radian}, "joint.csv"); }
  void TearDown() override { forget_axis(); }
};

using Gravity = OnARotaryAxis;

TEST_F(Gravity, IsASineOfOneTurnWithViscousFrictionBesideIt) {
  const Diagnosis is = test::diagnosed(joint(gravity_Nm));
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  ASSERT_EQ(is.steps.size(), 3u);
  EXPECT_EQ(is.steps[1].effect, "force_ripple");
  EXPECT_EQ(is.steps[2].effect, "viscous");
  const Term& ripple = *find_term(is.explained.terms, "force_ripple");
  EXPECT_EQ(ripple.shapes[0], kTurn_rad);
  EXPECT_NEAR(std::hypot(ripple.gains[0], ripple.gains[1]), 20.0, 0.02);
  for (std::size_t i = 2; i < ripple.gains.size(); ++i) EXPECT_EQ(ripple.gains[i], 0.0) << i;
  EXPECT_LT(is.explained.holdout_rmse_N, 0.04);  // a line with a bend leaves 0.1 N m of gravity
}

// What a hose or a torsion spring does stays one.
TEST_F(Gravity, IsNoSpringThatStiffens) {
  const Diagnosis is = test::diagnosed(joint([](double q) { return 5.0 * q + 3.0 * q * q * q; }));
  ASSERT_GE(is.steps.size(), 2u);
  EXPECT_EQ(is.steps[1].effect, "cable_chain_stiffness");
  EXPECT_FALSE(contains(is.explained.terms, "force_ripple"));
}

TEST_F(Gravity, HasHarmonicsOnlyWhereTwoOfThemFitIntoTheTravel) {
  const Measurement measurement(joint(gravity_Nm));
  Term ripple = make_term(measurement, *find_effect("force_ripple"));
  const double travel = measurement.position_range_m().length();
  ASSERT_LT(travel, 0.5 * kTurn_rad);
  ripple.shapes[0] = 0.6 * travel;  // does not fit twice
  settle_pitch(measurement, ripple);
  EXPECT_TRUE(is_one_turn(ripple.shapes[0]));
  for (std::size_t i = 0; i < ripple.gains.size(); ++i) EXPECT_EQ(ripple.upper[i] > 0.0, i < 2) << i;
  ripple.shapes[0] = (0.5 + 1e-12) * travel;  // but for rounding it does
  settle_pitch(measurement, ripple);
  EXPECT_FALSE(is_one_turn(ripple.shapes[0]));
  ripple.shapes[0] = 0.4 * travel;
  settle_pitch(measurement, ripple);
  EXPECT_EQ(ripple.shapes[0], 0.4 * travel);
  for (std::size_t i = 0; i < ripple.gains.size(); ++i) EXPECT_GT(ripple.upper[i], 0.0) << i;
}

TEST(OnALinearAxis, NoPitchIsATurn) {
  const Measurement measurement(joint(gravity_Nm));
  Term ripple = make_term(measurement, *find_effect("force_ripple"));
  ripple.shapes[0] = kTurn_rad;
  settle_pitch(measurement, ripple);
  EXPECT_FALSE(is_one_turn(ripple.shapes[0]));
}

}  // namespace
}  // namespace slipstack::workbench
