// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/guideway.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_host/experiments/quasi_static.h"
#include "workbench/papers/analysis/loop_log.h"

// The scaling law of [2] on measured loops: what another guideway does is predicted from one, then measured.
namespace slipstack::workbench {
namespace {

constexpr BallContact kReference{54.0, 90.0, 6e-3, 2.0, BallMaterial::kSteel};

/// The guideway as it is: virgin curve in the variables of the law, written out by hand for a radius in mm.
sim::VirginCurve curve_of(const BallContact& contact) {
  const double half = 0.5 * contact.groove_angle_deg * 3.14159265358979323846 / 180.0;
  const double s2 = std::sin(half) * std::sin(half);
  const double level_N = 0.02 * std::sqrt(contact.load_per_ball_N) * contact.balls / s2;
  const double length_m = 3e-6 * std::sqrt(contact.ball_diameter_m * 500.0) * s2;
  return sim::VirginCurve({{sim::CurveKind::kRational, level_N, length_m},
                           {sim::CurveKind::kExponential, 0.4 * level_N, 5.0 * length_m}});
}

AveragedLoop largest_loop(const BallContact& contact, std::uint64_t seed) {
  const sim::VirginCurve curve = curve_of(contact);
  sim::QuasiStaticTest test;
  test.forces_N = {0.85 * curve.saturation_N()};
  test.encoder_resolution_m = 1e-9;
  test.force_noise_N = 2e-3 * curve.saturation_N();
  test.seed = seed;
  const sim::QuasiStaticRecord log = sim::record_loops(sim::MaxwellElements::sample(curve, 200), test);
  return averaged_loops(log.position_m, log.force_N).front();
}

std::vector<BallContact> tested() {
  std::vector<BallContact> contacts;
  for (const double load : {10.0, 25.0, 55.0}) {
    for (const double angle : {60.0, 90.0, 120.0}) {
      for (const double diameter : {1.5e-3, 6e-3}) {
        contacts.push_back({load, angle, diameter, 2.0, BallMaterial::kSteel});
      }
    }
  }
  return contacts;
}

TEST(Guideway, ScalingLawCollapsesTheLoops) {
  std::vector<Loop> raw;
  std::vector<Loop> collapsed;
  std::vector<Loop> without_angle;
  for (const BallContact& contact : tested()) {
    raw.push_back(largest_loop(contact, raw.size() + 1).loop);
    collapsed.push_back(scaled(raw.back(), scaling(contact, kReference)));
    BallContact blind = contact;
    blind.groove_angle_deg = kReference.groove_angle_deg;
    without_angle.push_back(scaled(raw.back(), scaling(blind, kReference)));
  }
  EXPECT_GT(loop_spread(raw), 0.3);
  EXPECT_LT(loop_spread(collapsed), 0.01);
  EXPECT_GT(loop_spread(collapsed), 1e-5) << "better than the noise allows";
  // The measure sees a factor that is left out.
  EXPECT_GT(loop_spread(without_angle), 0.2);
}

TEST(Guideway, PredictsTheLoopOfAnother) {
  const AveragedLoop reference = largest_loop(kReference, 1);
  const PolygonCurve curve = fit_polygon(reference.loop).curve;
  std::uint64_t seed = 100;
  for (BallContact contact : tested()) {
    contact.balls = 7.0;
    const GuidewayPrediction found = predict(reference.loop, curve, kReference, contact);
    const AveragedLoop truth = largest_loop(contact, ++seed);
    EXPECT_NEAR(found.figures.force_N, truth.figures.force_N, 0.01 * truth.figures.force_N);
    EXPECT_NEAR(found.figures.amplitude_m, truth.figures.amplitude_m, 0.03 * truth.figures.amplitude_m);
    EXPECT_NEAR(found.figures.damping_ratio, truth.figures.damping_ratio, 0.03 * truth.figures.damping_ratio);
    // k₀ = y′(0) of the true curve: rational 2h₀/δ, exponential S₀/ℓ.
    double k0 = 0.0;
    const sim::VirginCurve true_curve = curve_of(contact);
    for (const sim::CurveTerm& term : true_curve.terms()) {
      k0 += (term.kind == sim::CurveKind::kRational ? 2.0 : 1.0) * term.level_N / term.length_m;
    }
    EXPECT_NEAR(found.initial_stiffness_N_per_m, k0, 0.1 * k0);
  }
}

TEST(Guideway, FactorsOfOneChangeAreTheLaws) {
  BallContact other = kReference;
  other.load_per_ball_N = 4.0 * kReference.load_per_ball_N;
  EXPECT_NEAR(scaling(kReference, other).force, 2.0, 1e-12);
  EXPECT_NEAR(scaling(kReference, other).displacement, 1.0, 1e-12);
  other = kReference;
  other.balls = 6.0;
  EXPECT_NEAR(scaling(kReference, other).force, 3.0, 1e-12);
  other = kReference;
  other.ball_diameter_m = 1.5e-3;
  EXPECT_NEAR(scaling(kReference, other).displacement, 0.5, 1e-12);
  EXPECT_NEAR(scaling(kReference, other).stiffness(), 2.0, 1e-12);
  other = kReference;
  other.groove_angle_deg = 60.0;  // sin²(30°) = 1/4 against sin²(45°) = 1/2
  EXPECT_NEAR(scaling(kReference, other).force, 2.0, 1e-12);
  EXPECT_NEAR(scaling(kReference, other).displacement, 0.5, 1e-12);
  // There and back.
  other = {20.0, 120.0, 1.5e-3, 5.0, BallMaterial::kSteel};
  EXPECT_NEAR(scaling(kReference, other).force * scaling(other, kReference).force, 1.0, 1e-12);
}

TEST(Guideway, SteelIsDampedLessThanCeramics) {
  const AveragedLoop reference = largest_loop(kReference, 1);
  const PolygonCurve curve = fit_polygon(reference.loop).curve;
  BallContact ceramic = kReference;
  ceramic.material = BallMaterial::kSiliconNitride;
  const GuidewayPrediction found = predict(reference.loop, curve, kReference, ceramic);
  EXPECT_LT(found.scaling.displacement, 1.0);  // pre-rolling travel is longest for steel
  EXPECT_EQ(found.scaling.force, 1.0);
  double sum = 0.0;
  int count = 0;
  for (double share = 0.3; share <= 0.9; share += 0.05) {
    const double A = share * curve.reach_m();
    const double steel = figures_of(masing_loop(curve, A, 2000)).damping_ratio;
    const double nitride = figures_of(masing_loop(found.curve, A, 2000)).damping_ratio;
    sum += steel / nitride;
    ++count;
  }
  EXPECT_NEAR(sum / count, 0.78, 0.01);
  EXPECT_NEAR(material_scale(curve, BallMaterial::kDiamondCoated, BallMaterial::kSiliconNitride), 1.0, 0.0);
}

TEST(Guideway, RefusesWhatNoGuidewayIs) {
  BallContact bad = kReference;
  bad.load_per_ball_N = -1.0;
  EXPECT_THROW(scaling(kReference, bad), std::invalid_argument);
  bad = kReference;
  bad.groove_angle_deg = 200.0;
  EXPECT_THROW(scaling(bad, kReference), std::invalid_argument);
  bad = kReference;
  bad.ball_diameter_m = 0.0;
  EXPECT_THROW(check(bad), std::invalid_argument);
  bad = kReference;
  bad.balls = std::nan("");
  EXPECT_THROW(check(bad), std::invalid_argument);
  EXPECT_FALSE(ball_material("wood").has_value());
  EXPECT_EQ(ball_material("steel"), BallMaterial::kSteel);
}

}  // namespace
}  // namespace slipstack::workbench
