// SPDX-License-Identifier: Apache-2.0
#include "firmware/friction/virgin_curves.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace slipstack {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// y(0) = 0, stiffness = dy/dx by central difference, slope falling (passive), saturation at `height`.
template <class Curve>
void expect_virgin_curve(const Curve& curve, double reach, double height) {
  EXPECT_EQ(curve.force(0.0), 0.0);
  double slope_before = kInfinity;
  for (int i = 1; i < 2000; ++i) {
    const double x = reach * i / 2000;
    const double h = 1e-4 * x;
    const double slope = curve.stiffness(x);
    ASSERT_NEAR((curve.force(x + h) - curve.force(x - h)) / (2 * h), slope, 1e-5 * curve.stiffness(0.0)) << x;
    ASSERT_GE(slope, 0.0);
    ASSERT_LE(slope, slope_before);
    slope_before = slope;
  }
  EXPECT_NEAR(curve.force(1e6 * reach), height, 1e-6 * height);
}

TEST(RationalCurve, HasItsShape) {
  constexpr RationalCurve<double> kCurve{15.0, 12.0};
  expect_virgin_curve(kCurve, 100.0, 15.0);
  EXPECT_DOUBLE_EQ(kCurve.stiffness(0.0), 2 * 15.0 / 12.0);
  EXPECT_DOUBLE_EQ(kCurve.force(12.0), 15.0 * 0.75);
  // Small displacements keep their digits: y = k0 x (1 - 3x / (2 delta) + ...).
  const double x = 1e-12;
  EXPECT_NEAR(kCurve.force(x) / (2.5 * x), 1.0, 1e-12);
}

TEST(VirginCurves, SayWhenTheirParametersAreUseless) {
  EXPECT_TRUE((RationalCurve<double>{0.0, 1.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{-1.0, 1.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{1.0, 0.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{kNan, 1.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{1.0, kInfinity}.valid()));
  EXPECT_FALSE((RationalCurve<double>{1.0, -2.0}.valid()));
  EXPECT_TRUE((RationalCurve<double>{1.0, 2.0}.valid()));
}

TEST(PiecewiseLinearCurve, GoesThroughItsKnots) {
  constexpr std::array<double, 3> kX = {1.0, 3.0, 7.0};
  constexpr std::array<double, 3> kForce = {4.0, 6.0, 7.0};
  PiecewiseLinearCurve<5, double> curve;
  ASSERT_EQ(curve.set_knots(kX, kForce), SetupStatus::kOk);
  EXPECT_EQ(curve.force(0.0), 0.0);
  EXPECT_EQ(curve.force(0.5), 2.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(curve.force(kX[i]), kForce[i]);
  EXPECT_EQ(curve.force(2.0), 5.0);
  EXPECT_EQ(curve.force(100.0), 7.0);
  EXPECT_EQ(curve.stiffness(0.0), 4.0);
  EXPECT_EQ(curve.stiffness(1.0), 1.0);
  EXPECT_EQ(curve.stiffness(6.9), 0.25);
  EXPECT_EQ(curve.stiffness(7.0), 0.0);
  EXPECT_EQ((PiecewiseLinearCurve<5, double>{}.force(3.0)), 0.0);
}

// The EMRP SIB63 rule: Delta_i = x_i, k_i = slope before the knot less slope after it.
TEST(PiecewiseLinearCurve, GivesTheEqualElements) {
  constexpr std::array<double, 3> kX = {1.0, 3.0, 7.0};
  constexpr std::array<double, 3> kForce = {4.0, 6.0, 7.0};
  PiecewiseLinearCurve<5, double> curve;
  ASSERT_EQ(curve.set_knots(kX, kForce), SetupStatus::kOk);
  std::array<double, 3> slip{};
  std::array<double, 3> stiffness{};
  curve.elements(slip, stiffness);
  EXPECT_EQ(slip, kX);
  EXPECT_EQ(stiffness, (std::array<double, 3>{3.0, 0.75, 0.25}));
  PiecewiseLinearCurve<3, double> again;
  ASSERT_EQ(again.set_slopes(slip, std::array<double, 3>{4.0, 1.0, 0.25}), SetupStatus::kOk);
  for (double x = 0; x < 9; x += 0.1) EXPECT_DOUBLE_EQ(again.force(x), curve.force(x));
}

TEST(PiecewiseLinearCurve, RefusesBadKnotsAndKeepsTheOldOnes) {
  constexpr std::array<double, 2> kX = {1.0, 2.0};
  constexpr std::array<double, 2> kForce = {4.0, 6.0};
  PiecewiseLinearCurve<2, double> curve;
  ASSERT_EQ(curve.set_knots(kX, kForce), SetupStatus::kOk);
  const std::array<double, 1> one = {1.0};
  const std::array<double, 3> three = {1.0, 2.0, 3.0};
  EXPECT_EQ(curve.set_knots(kX, one), SetupStatus::kSizeMismatch);
  EXPECT_EQ(curve.set_knots(three, three), SetupStatus::kTooMany);
  EXPECT_EQ(curve.set_knots(std::array{2.0, 2.0}, kForce), SetupStatus::kNotAscending);
  EXPECT_EQ(curve.set_knots(std::array{0.0, 2.0}, kForce), SetupStatus::kNotAscending);
  EXPECT_EQ(curve.set_knots(std::array{1.0, kNan}, kForce), SetupStatus::kOutOfRange);
  EXPECT_EQ(curve.set_slopes(kX, std::array{1.0, kInfinity}), SetupStatus::kOutOfRange);
  EXPECT_EQ(curve.set_slopes(std::array{-1.0, 2.0}, kForce), SetupStatus::kNotAscending);
  EXPECT_EQ(curve.force(1.5), 5.0);
}

}  // namespace
}  // namespace slipstack
