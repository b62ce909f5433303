// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/characterize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "workbench/papers/analysis/virgin_fit.h"

// What [2] saw: ζᵣ of four preloads coincide while their loops differ; 2.1, 3 and 6 % at 1, 2 and 10 µm.
namespace slipstack::workbench {
namespace {

constexpr double kPreloads_N[] = {10.0, 20.0, 35.0, 55.0};

std::vector<AveragedLoop> measured(const sim::VirginCurve& curve, std::uint64_t seed) {
  LoopTest test;
  test.amplitudes_m = {1e-6, 2.1e-6, 4.5e-6, 9.5e-6, 20e-6};
  test.encoder_resolution_m = 1e-9;
  test.force_noise_N = 1e-3 * curve.saturation_N();
  test.seed = seed;
  return characterize(curve, test);
}

TEST(Characterize, DampingRatiosOfFourPreloadsCoincideWhileLoopsDiffer) {
  std::vector<std::vector<AveragedLoop>> all;
  for (const double preload_N : kPreloads_N) {
    // √W on the force axis ([2], 4.4.2).
    const double level_N = 0.35 * std::sqrt(preload_N / 10.0);
    all.push_back(measured(sim::VirginCurve({{sim::CurveKind::kRational, level_N, 3e-6}}),
                           static_cast<std::uint64_t>(preload_N)));
    ASSERT_EQ(all.back().size(), 5u);
  }
  for (std::size_t i = 0; i < 5; ++i) {
    double least = 1.0;
    double most = 0.0;
    for (const auto& loops : all) {
      least = std::min(least, loops[i].figures.damping_ratio);
      most = std::max(most, loops[i].figures.damping_ratio);
    }
    EXPECT_LT(most - least, 0.03 * most) << "amplitude " << i;
    const double softest = all.front()[i].figures.force_N;
    const double hardest = all.back()[i].figures.force_N;
    EXPECT_NEAR(hardest / softest, std::sqrt(5.5), 0.03);
    // cₑω grows with preload as kₑ does.
    EXPECT_NEAR(all.back()[i].figures.damping_N_per_m / all.front()[i].figures.damping_N_per_m,
                std::sqrt(5.5), 0.1);
  }
}

TEST(Characterize, RationalCurveIsFoundInItsLoops) {
  const sim::VirginCurve curve({{sim::CurveKind::kRational, 4.75, 1e-6}});
  std::vector<Loop> loops;
  for (const AveragedLoop& loop : measured(curve, 7)) loops.push_back(loop.loop);
  const RationalFit fit = fit_rational(loops);
  EXPECT_NEAR(fit.curve.level_N, 4.75, 0.05);
  EXPECT_NEAR(fit.curve.length_m, 1e-6, 0.03e-6);
  EXPECT_LT(fit.relative_error, 0.01);
  EXPECT_GT(fit.relative_error, 1e-5);
}

TEST(Characterize, AnotherCurveIsNotTakenForARationalOne) {
  const sim::VirginCurve curve({{sim::CurveKind::kExponential, 4.75, 3e-6}});
  std::vector<Loop> loops;
  for (const AveragedLoop& loop : measured(curve, 7)) loops.push_back(loop.loop);
  EXPECT_GT(fit_rational(loops).relative_error, 0.01);
}

TEST(Characterize, TypicalDampingRatiosOfThePaperAreReached) {
  // [2], 4.4.2: about 6 % at 10 µm, 3 % at 2 µm, 2.1 % at 1 µm by extrapolation.
  const sim::VirginCurve curve = curve_of_damping({{1e-6, 0.021}, {2e-6, 0.03}, {10e-6, 0.06}}, 1.0);
  EXPECT_NEAR(curve.force_N(10e-6), 1.0, 1e-9);
  const auto at = [&](double A) {
    return figures_of_virgin([&](double x) { return curve.force_N(x); }, A).damping_ratio;
  };
  EXPECT_NEAR(at(1e-6), 0.021, 1e-3);
  EXPECT_NEAR(at(2e-6), 0.030, 1e-3);
  EXPECT_NEAR(at(10e-6), 0.060, 1e-3);
  // The paper's own curve cannot do that: through 6 % at 10 µm it has 1.3 % at 2 µm.
  const double delta = 0.5 * (2.0 / 3.14159265358979 * 10e-6 / 0.06 - 10e-6);
  EXPECT_NEAR((RationalCurve{1.0, delta}.closed_form(2e-6).damping_ratio), 0.013, 0.001);
  // And in loops as they are measured, with an encoder and noise.
  LoopTest test;
  test.amplitudes_m = {1e-6, 2e-6, 10e-6};
  test.encoder_resolution_m = 1e-9;
  test.force_noise_N = 2e-4;
  const auto loops = characterize(curve, test);
  ASSERT_EQ(loops.size(), 3u);
  EXPECT_NEAR(loops[0].figures.damping_ratio, 0.021, 0.002);
  EXPECT_NEAR(loops[1].figures.damping_ratio, 0.030, 0.002);
  EXPECT_NEAR(loops[2].figures.damping_ratio, 0.060, 0.002);
}

TEST(Characterize, ScalingLawCollapsesTheGuidewaysThatWereTried) {
  const BallContact reference{54.0, 90.0, 6e-3, 2.0, BallMaterial::kSteel};
  LoopTest test;
  test.encoder_resolution_m = 10e-9;
  test.force_noise_N = 1e-3;
  const auto tried =
      guideways_tried(sim::VirginCurve({{sim::CurveKind::kRational, 0.35, 3e-6}}), reference, test);
  ASSERT_EQ(tried.size(), 8u);
  std::vector<Loop> raw;
  std::vector<Loop> collapsed;
  for (const GuidewayLoop& one : tried) {
    raw.push_back(one.loop.loop);
    collapsed.push_back(scaled(one.loop.loop, scaling(one.contact, reference)));
  }
  EXPECT_GT(loop_spread(raw), 0.15);
  EXPECT_LT(loop_spread(collapsed), 0.01);
  EXPECT_GT(loop_spread(collapsed), 1e-5);
}

TEST(Characterize, AmplitudesThatTheEncoderCannotSeeAreLeftOut) {
  const sim::VirginCurve curve({{sim::CurveKind::kRational, 15.0, 12e-6}});
  LoopTest test;
  test.amplitudes_m = {2e-6, 40e-6};
  test.encoder_resolution_m = 1e-6;
  EXPECT_EQ(characterize(curve, test).size(), 1u);
  test.amplitudes_m = {2e-6};
  EXPECT_THROW(characterize(curve, test), std::invalid_argument);
  test.amplitudes_m = {-2e-6};
  EXPECT_THROW(characterize(curve, test), std::invalid_argument);
}

TEST(Characterize, DampingThatNoCurveHasIsRefused) {
  EXPECT_THROW(curve_of_damping({}, 1.0), std::invalid_argument);
  EXPECT_THROW(curve_of_damping({{1e-6, 0.7}}, 1.0), std::invalid_argument);
  EXPECT_THROW(curve_of_damping({{-1e-6, 0.1}}, 1.0), std::invalid_argument);
}

TEST(Characterize, PolygonFollowsAnyConcaveLoop) {
  const sim::VirginCurve curve({{sim::CurveKind::kStretched, 3.0, 4e-6, 0.7}});
  const auto loops = measured(curve, 3);
  const PolygonFit fit = fit_polygon(loops.back().loop);
  EXPECT_LT(fit.relative_error, 0.01);
  for (const double x : {2e-6, 5e-6, 15e-6}) {
    EXPECT_NEAR(fit.curve.force_at_N(x), curve.force_N(x), 0.02 * curve.force_N(x));
  }
  double slope = 1e300;
  for (std::size_t i = 0; i < fit.curve.force_N.size(); ++i) {
    const double x0 = i == 0 ? 0.0 : fit.curve.displacement_m[i - 1];
    const double y0 = i == 0 ? 0.0 : fit.curve.force_N[i - 1];
    const double next = (fit.curve.force_N[i] - y0) / (fit.curve.displacement_m[i] - x0);
    EXPECT_LE(next, slope * (1.0 + 1e-9));
    slope = next;
  }
}

TEST(Characterize, ALoopThatIsNotConcaveIsRefused) {
  // Branches that stiffen towards the tips, with a little viscous area.
  Loop loop;
  for (int i = 0; i < 400; ++i) {
    const double t = 2.0 * 3.14159265358979 * i / 400.0;
    loop.position_m.push_back(std::sin(t));
    loop.force_N.push_back(std::pow(std::sin(t), 5) + 0.02 * std::cos(t));
  }
  EXPECT_THROW(fit_polygon(loop), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::workbench
