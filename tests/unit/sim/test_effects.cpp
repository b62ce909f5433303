// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim_host/plant/effects/effect_id.h"
#include "sim_host/plant/effects/effects.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

TEST(EffectId, NamesAndNumbersAgree) {
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const auto id = effect_by_name(kEffectNames[i]);
    ASSERT_TRUE(id.has_value());
    EXPECT_EQ(index(*id), i);
  }
  EXPECT_FALSE(effect_by_name("stribek").has_value());
}

TEST(WeakeningCurve, FallsFromOneToItsDepthTheSameBothWays) {
  for (const WeakeningKind kind :
       {WeakeningKind::kGaussian, WeakeningKind::kTustin, WeakeningKind::kLorentzian,
        WeakeningKind::kBoPavelescu, WeakeningKind::kHyperbolic}) {
    const WeakeningCurve curve = {kind, 0.4, 0.01, 0.7};
    EXPECT_EQ(curve.level(0.0), 1.0);
    EXPECT_NEAR(curve.level(1e4), 0.6, 1e-6);
    double last = 1.0;
    for (double v = 1e-4; v < 1.0; v *= 1.1) {
      EXPECT_LT(curve.level(v), last) << name(kind);
      EXPECT_EQ(curve.level(v), curve.level(-v));
      last = curve.level(v);
      if (last < 0.6 + 1e-12) break;
    }
  }
}

// Whatever its law, the lag ends at the Stribeck curve; after one time constant of a step it has gone 1 −
// 1/e.
TEST(FrictionalLag, SettlesOnItsCurve) {
  for (const LagKind kind : {LagKind::kTime, LagKind::kDistance, LagKind::kAttraction}) {
    FrictionalLag lag;
    lag.kind = kind;
    lag.curve = {WeakeningKind::kGaussian, 0.3, 0.01, 1.0};
    const double target = lag.curve.level(0.02);
    const auto [rate, goal] = lag.relaxation(0.02);
    EXPECT_EQ(goal, target);
    const double expected = kind == LagKind::kTime       ? 1.0 / lag.time_s
                            : kind == LagKind::kDistance ? 0.02 / lag.distance_m
                                                         : lag.attraction_per_s / target;
    EXPECT_DOUBLE_EQ(rate, expected);
  }
}

TEST(PositionMap, HasMeanZeroAndUnitSize) {
  Rng rng(2);
  std::vector<double> knots(6);
  for (double& knot : knots) knot = rng.normal();
  const double stroke = 0.4;
  const std::vector<PositionMap> maps = {PositionMap::spline(stroke, knots),
                                         PositionMap::piecewise_linear(stroke, knots),
                                         PositionMap::sines(stroke, {{1.0, 0.3, 0.2}, {0.4, 0.11, 1.0}}),
                                         PositionMap::bump(stroke, 0.12, 0.04), PositionMap::trend(stroke)};
  for (const PositionMap& map : maps) {
    double sum = 0.0;
    double squares = 0.0;
    double jump = 0.0;
    constexpr int kPoints = 40000;
    double last = map.value(0.0);
    for (int i = 0; i < kPoints; ++i) {
      const double y = map.value(stroke * (i + 0.5) / kPoints);
      sum += y;
      squares += y * y;
      jump = std::max(jump, std::fabs(y - last));
      last = y;
      ASSERT_LE(std::fabs(y), map.peak() * (1.0 + 1e-4));
    }
    EXPECT_NEAR(sum / kPoints, 0.0, 1e-4) << name(map.kind());
    EXPECT_NEAR(squares / kPoints, 1.0, 1e-4) << name(map.kind());
    EXPECT_LT(jump, 1e-2) << name(map.kind());
    EXPECT_EQ(map.value(-1.0), map.value(0.0));
  }
}

// A spline passes through its knots and has a continuous slope; the broken line has corners.
TEST(PositionMap, SplineIsSmoothWhereTheBrokenLineHasCorners) {
  const std::vector<double> knots = {0.0, 1.0, -0.5, 0.7, 0.2};
  const PositionMap spline = PositionMap::spline(1.0, knots);
  const PositionMap line = PositionMap::piecewise_linear(1.0, knots);
  const double scale = (spline.value(0.25) - spline.value(0.0)) / (knots[1] - knots[0]);
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    const double x = 0.25 * static_cast<double>(i);
    EXPECT_NEAR(spline.value(x) - spline.value(0.0), scale * (knots[i] - knots[0]), 1e-12);
    const auto kink = [x](const PositionMap& map) {
      const double h = 1e-5;
      return std::fabs(map.value(x + h) - 2.0 * map.value(x) + map.value(x - h)) / h;
    };
    EXPECT_LT(kink(spline), 0.01);
    EXPECT_GT(kink(line), 1.0);
  }
}

TEST(Ripple, RepeatsWithItsPitch) {
  const Ripple ripple = {0.024, {{1, 2.0, 0.3}, {3, 0.5, 1.0}}};
  for (double x = 0.0; x < 0.1; x += 0.0007) EXPECT_NEAR(ripple.value(x), ripple.value(x + 0.024), 1e-12);
}

TEST(Effects, LawsHaveTheRightLimits) {
  EXPECT_DOUBLE_EQ((Viscous{10.0, 0.9}.force_N(0.1)), 1.0);
  EXPECT_DOUBLE_EQ((Viscous{10.0, 1.0}.force_N(-0.3)), -3.0);
  EXPECT_DOUBLE_EQ((QuadraticDrag{2.0, 2.0}.force_N(-0.5)), -0.5);
  EXPECT_NEAR((QuadraticDrag{2.0, 1.9}.force_N(-1.0)), -2.0, 1e-15);
  for (const auto law :
       {AccelerationLaw::kProportional, AccelerationLaw::kSmooth, AccelerationLaw::kSaturating}) {
    const AccelerationPreload preload = {law, 0.1, 1.0};
    EXPECT_EQ(preload.factor(0.0), 1.0);
    EXPECT_GT(preload.factor(3.0), preload.factor(1.0));
    EXPECT_EQ(preload.factor(3.0), preload.factor(-3.0));
  }
  const DirectionAsymmetry asymmetry = {AsymmetryLaw::kByForce, 0.2, 0.0};
  EXPECT_NEAR(asymmetry.factor(10.0, 10.0, 0.1), 1.2, 1e-12);
  EXPECT_NEAR(asymmetry.factor(-10.0, 10.0, -0.1), 0.8, 1e-12);
  for (const auto kind : {DriftKind::kWarming, DriftKind::kLinear, DriftKind::kRunIn, DriftKind::kCreep}) {
    EXPECT_EQ((Drift{kind, DriftTarget::kHysteresis, 0.3, 10.0}.factor(0.0)), 1.0);
  }
  EXPECT_NEAR((Drift{DriftKind::kRunIn, DriftTarget::kHysteresis, 0.3, 1.0}.factor(1e9)), 0.7, 1e-6);
  EXPECT_NEAR((Drift{DriftKind::kWarming, DriftTarget::kHysteresis, 0.3, 1.0}.factor(1e9)), 1.3, 1e-6);
  const CableChain cable = {100.0, 0.1, 0.5, 0.4};
  EXPECT_EQ(cable.force_N(0.1), 0.0);
  EXPECT_NEAR(cable.force_N(0.5), 100.0 * 0.4 * 1.5, 1e-12);
}

}  // namespace
}  // namespace slipstack::sim
