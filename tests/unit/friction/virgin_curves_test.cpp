// SPDX-License-Identifier: Apache-2.0
#include "firmware/friction/virgin_curves.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "firmware/friction/decay.h"

namespace slipstack {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Real>
void expect_decay_accurate(double largest, double least_epsilons, double most_epsilons) {
  const double epsilon = static_cast<double>(std::numeric_limits<Real>::epsilon());
  double worst = 0;
  for (double exact = 1e-12; exact < largest; exact *= 1.0007) {
    const auto u = static_cast<Real>(exact);
    const Decay<Real> found = decay(u);
    const long double remaining = std::exp(-static_cast<long double>(u));
    const long double gone = -std::expm1(-static_cast<long double>(u));
    const long double off_remaining = std::abs(static_cast<long double>(found.remaining) / remaining - 1);
    const long double off_gone = std::abs(static_cast<long double>(found.gone) / gone - 1);
    worst = std::max(worst, static_cast<double>(std::max(off_remaining, off_gone)));
  }
  EXPECT_LT(worst, most_epsilons * epsilon);
  EXPECT_GT(worst, least_epsilons * epsilon);
}

TEST(Decay, IsAccurate) {
  expect_decay_accurate<double>(690.0, 0.5, 1.5);
  expect_decay_accurate<float>(86.0, 0.5, 0.9);
}

TEST(Decay, HoldsAtTheEnds) {
  EXPECT_EQ(decay(0.0).gone, 0.0);
  EXPECT_EQ(decay(0.0).remaining, 1.0);
  EXPECT_EQ(decay(1e9F).gone, 1.0F);
  EXPECT_EQ(decay(kInfinity).gone, 1.0);
  EXPECT_GT(decay(1e30).remaining, 0.0);
  // A NaN must not turn into an index or a shift out of range.
  EXPECT_EQ(decay(kNan).gone, 1.0);
}

TEST(Decay, NeverFallsBack) {
  float before = -1.0F;
  for (float u = 0.0F; u < 20.0F; u += 0.00037F) {
    const float gone = decay(u).gone;
    ASSERT_GE(gone, before) << u;
    before = gone;
  }
}

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

TEST(ExponentialCurve, HasItsShape) {
  constexpr ExponentialCurve<double> kCurve{4.75, 20.0};
  expect_virgin_curve(kCurve, 100.0, 4.75);
  EXPECT_DOUBLE_EQ(kCurve.stiffness(0.0), 4.75 / 20.0);
  EXPECT_NEAR(kCurve.force(20.0), 4.75 * (1 - std::exp(-1.0)), 1e-14);
}

TEST(VirginCurves, SayWhenTheirParametersAreUseless) {
  EXPECT_TRUE((RationalCurve<double>{0.0, 1.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{-1.0, 1.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{1.0, 0.0}.valid()));
  EXPECT_FALSE((RationalCurve<double>{kNan, 1.0}.valid()));
  EXPECT_FALSE((ExponentialCurve<double>{1.0, kInfinity}.valid()));
  EXPECT_FALSE((ExponentialCurve<double>{1.0, -2.0}.valid()));
  EXPECT_TRUE((ExponentialCurve<double>{1.0, 2.0}.valid()));
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
