// SPDX-License-Identifier: Apache-2.0
// The cubic B-spline map against the recursion that defines B-splines.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

constexpr int kSplines = kPreloadMapSplines;
constexpr int kIntervals = kSplines - 3;
constexpr double kStart_m = -0.13;
constexpr double kLength_m = 0.37;
using Weights = std::array<double, kSplines>;

Weights weights_at(double position_m) {
  PositionDependentPreload<double> effect;
  effect.prepare(std::array{kStart_m, kLength_m}, {.tick_s = 1e-4});
  Weights out{};
  effect.basis({.position_m = position_m}, out);
  return out;
}

/// Spline of degree p over the integer knots i .. i + p + 1, by de Boor, Cox and Mansfield (1972).
double b_spline(int i, int degree, double u) {
  if (degree == 0) return u >= i && u < i + 1 ? 1.0 : 0.0;
  return (u - i) / degree * b_spline(i, degree - 1, u) +
         (i + degree + 1 - u) / degree * b_spline(i + 1, degree - 1, u);
}

double place(double u) {
  return kStart_m + kLength_m * u / kIntervals;
}

TEST(PreloadMap, FollowsTheRecursion) {
  for (int k = 0; k < 9000; ++k) {
    const double u = kIntervals * (k + 0.37) / 9000.0;
    const Weights is = weights_at(place(u));
    for (int j = 0; j < kSplines; ++j) {
      EXPECT_NEAR(is[static_cast<std::size_t>(j)], b_spline(j - 3, 3, u), 1e-13) << u << ' ' << j;
    }
  }
}

TEST(PreloadMap, SumsToOneWithFourAtATime) {
  for (double x = kStart_m - 0.1; x < kStart_m + kLength_m + 0.1; x += 1e-4) {
    double sum = 0.0;
    int used = 0;
    for (const double weight : weights_at(x)) {
      EXPECT_GE(weight, 0.0);
      sum += weight;
      used += weight > 0.0 ? 1 : 0;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_LE(used, 4);
    EXPECT_GE(used, 3);
  }
}

/// Value, slope and curvature of spline j over u, taken on one side of a place by extrapolation-free
/// one-sided differences of a cubic (exact: four points determine it).
struct Jet {
  double value, slope, curvature;
};
Jet jet(std::size_t j, double u, double side) {
  const double h = side * 0.125;
  std::array<double, 4> f{};
  for (std::size_t k = 0; k < 4; ++k) {
    // Within the interval on that side; k = 0 only just, so that rounding cannot cross the knot.
    f[k] = weights_at(place(u + h * static_cast<double>(k) + (k == 0 ? side * 1e-12 : 0.0)))[j];
  }
  return {f[0], (-11.0 * f[0] + 18.0 * f[1] - 9.0 * f[2] + 2.0 * f[3]) / (6.0 * h),
          (2.0 * f[0] - 5.0 * f[1] + 4.0 * f[2] - f[3]) / (h * h)};
}

TEST(PreloadMap, IsTwiceContinuouslyDifferentiable) {
  for (int knot = 1; knot < kIntervals; ++knot) {
    for (std::size_t j = 0; j < kSplines; ++j) {
      const Jet left = jet(j, knot, -1.0);
      const Jet right = jet(j, knot, 1.0);
      EXPECT_NEAR(left.value, right.value, 1e-10);
      EXPECT_NEAR(left.slope, right.slope, 1e-9);
      EXPECT_NEAR(left.curvature, right.curvature, 1e-8);
    }
  }
}

TEST(PreloadMap, HoldsItsEndsOutside) {
  const Weights first = weights_at(kStart_m);
  const Weights last = weights_at(kStart_m + kLength_m);
  for (const double beyond : {1e-9, 0.01, 1.0, 1e6, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(weights_at(kStart_m - beyond), first) << beyond;
    const Weights outside = weights_at(kStart_m + kLength_m + beyond);
    for (std::size_t j = 0; j < kSplines; ++j) EXPECT_NEAR(outside[j], last[j], 1e-14) << beyond;
  }
  EXPECT_NEAR(first[0], 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(first[1], 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(last[kSplines - 1], 1.0 / 6.0, 1e-14);
}

// A position that is no number must not become a place in memory.
TEST(PreloadMap, SurvivesNotANumber) {
  const Weights lost = weights_at(std::nan(""));
  double sum = 0.0;
  for (const double weight : lost) sum += weight;
  EXPECT_NEAR(sum, 1.0, 1e-14);
}

// Cubic splines on a uniform grid hold every straight line: w_j = centre of spline j.
TEST(PreloadMap, ReproducesAStraightLine) {
  for (double u = 0.0; u <= kIntervals; u += 0.01) {
    const Weights weights = weights_at(place(u));
    double line = 0.0;
    for (std::size_t j = 0; j < kSplines; ++j) line += weights[j] * (static_cast<double>(j) - 1.0);
    EXPECT_NEAR(line, u, 1e-12);
  }
}

TEST(PreloadMap, FloatAgreesToRounding) {
  PositionDependentPreload<float> target;
  target.prepare(std::array{static_cast<float>(kStart_m), static_cast<float>(kLength_m)}, {.tick_s = 1e-4F});
  double worst = 0.0;
  for (double u = 0.0; u <= kIntervals; u += 1e-3) {
    std::array<float, kSplines> out{};
    target.basis({.position_m = static_cast<float>(place(u))}, out);
    const Weights exact = weights_at(place(u));
    for (std::size_t j = 0; j < kSplines; ++j) {
      worst = std::max(worst, std::abs(static_cast<double>(out[j]) - exact[j]));
    }
  }
  // The place is good to 2^-24 of 9 intervals in each of three roundings; the slope of a spline is at most
  // 2/3.
  EXPECT_LT(worst, 1.6e-6);
  EXPECT_GT(worst, 1e-7);
}

}  // namespace
}  // namespace slipstack
