// SPDX-License-Identifier: Apache-2.0
// Forces that resemble an effect but come from another one, or from none of the catalogue.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "sim_host/log/closed_loop.h"
#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/diagnose/verdict.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

using test::diagnosed;

constexpr double kTwoPi = 2.0 * std::numbers::pi;

sim::Bench bench_of(std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  bench.programme.seconds = 25.0;
  return bench;
}

std::vector<std::string> added(const Diagnosis& is) {
  std::vector<std::string> ids;
  for (std::size_t i = 1; i < is.steps.size(); ++i) ids.push_back(is.steps[i].effect);
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// A tenth of the mass swings at 24 Hz.
void let_swing(sim::Axis& axis) {
  sim::Resonance arm;
  arm.frequency_rad_per_s = kTwoPi * 24.0;
  arm.damping_ratio = 0.02;
  arm.ratio = 0.1;
  axis.effects.resonance = arm;
}

TEST(Confounders, AModeAloneNeedsNoPayload) {
  sim::Bench bench = bench_of(31);
  let_swing(bench.axis);
  EXPECT_EQ(added(diagnosed(test::simulate(bench, 31))), std::vector<std::string>{"structural_resonance"});
}

// Where no log declares the mass, the rigid mass of the mode and the mass of the axis have the same column:
// all of it is given to the axis.
TEST(Confounders, AModeLeavesAFittedMassToTheAxis) {
  sim::Bench bench = bench_of(31);
  let_swing(bench.axis);
  Log log = test::simulate(bench, 31);
  log.mass_kg.reset();
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(added(is), std::vector<std::string>{"structural_resonance"});
  const Term& mode = *find_term(is.explained.terms, "structural_resonance");
  EXPECT_EQ(mode.gains[2], 0.0);
  const double found_kg = mass_kg(is.explained.terms) + mode.gains[0];
  EXPECT_NEAR(found_kg, bench.axis.mass_kg, 0.01 * bench.axis.mass_kg);
  EXPECT_LT(mode.gains[0], 0.2 * bench.axis.mass_kg);
}

// An effect that predicts the last third worse than the baseline does, by 3 %, does not hold there, unless
// it explains most of it where some of its blocks are seen: then the first two thirds only do not determine
// it.
TEST(Confounders, AnEffectThatDoesNotHoldLaterHasNoName) {
  sim::Bench bench = bench_of(31);
  bench.axis.effects.payload_kg = 0.3 * bench.axis.mass_kg;
  Measurement measurement(test::simulate(bench, 31));
  Diagnosis is = diagnosed(measurement);
  is.explained.forward_within_travel_N = 2.0 * is.baseline.forward_within_travel_N;
  judge(measurement, is);
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  is.explained.last_third_holdout_rmse_N = 0.72 * is.baseline.last_third_holdout_rmse_N;
  judge(measurement, is);
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  ASSERT_TRUE(is.unexplained);
  EXPECT_NE(is.unexplained->description.find("in the last third of the log"), std::string::npos)
      << is.unexplained->description;
  is.explained.forward_within_travel_N = 1.02 * is.baseline.forward_within_travel_N;
  judge(measurement, is);
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
  is.explained.forward_within_travel_N = 1.04 * is.baseline.forward_within_travel_N;
  judge(measurement, is);
  EXPECT_EQ(is.verdict, Verdict::unexplained);
  is.explained.last_third_holdout_rmse_N = 0.70 * is.baseline.last_third_holdout_rmse_N;
  judge(measurement, is);
  EXPECT_EQ(is.verdict, Verdict::missing_effect);
}

// A fifth of a sample between two clocks is not a delay of the axis; in fast moves its residual resembles
// backlash.
TEST(Confounders, ErrorsOfInstrumentsAreMentionedBesideTheirSymptoms) {
  for (const double part_of_tick : {0.2, 1.5}) {
    sim::Bench bench = bench_of(33);
    bench.axis.force_noise_N *= 0.1;
    bench.axis.encoder_resolution_m *= 0.1;
    bench.axis.effects.delay = sim::RecordingDelay{part_of_tick / bench.rate_Hz, 0.0};
    const Diagnosis is = diagnosed(test::simulate(bench, 33));
    if (part_of_tick > 1.0) {
      EXPECT_EQ(added(is), std::vector<std::string>{"time_delay"});
      continue;
    }
    EXPECT_EQ(is.verdict, Verdict::unexplained);
    ASSERT_TRUE(is.unexplained);
    EXPECT_NE(is.unexplained->description.find("time_delay would lower the error"), std::string::npos)
        << is.unexplained->description;
  }
}

TEST(Confounders, APayloadBesideAModeIsNamed) {
  sim::Bench bench = bench_of(31);
  let_swing(bench.axis);
  bench.axis.effects.payload_kg = 0.06 * bench.axis.mass_kg;
  const Diagnosis is = diagnosed(test::simulate(bench, 31));
  ASSERT_EQ(added(is), (std::vector<std::string>{"payload_mass", "structural_resonance"}));
  const double found_kg = find_term(is.explained.terms, "payload_mass")->gains[0];
  EXPECT_NEAR(found_kg, 0.06 * bench.axis.mass_kg, 0.01 * bench.axis.mass_kg);
}

// So few counts are lost that the model stays good; they must be reported all the same. After the repair
// other effects are named as without lost counts.
TEST(Confounders, LostCountsAreReported) {
  for (const double payload_share : {0.0, 0.2}) {
    sim::Bench bench = bench_of(33);
    bench.axis.effects.payload_kg = payload_share * bench.axis.mass_kg;
    Log log = test::simulate(bench, 33);
    std::size_t at = log.position_m.size() / 2;
    while (std::abs(log.position_m[at + 1] - log.position_m[at]) * log.sample_rate_Hz < 0.03) ++at;
    for (std::size_t i = at; i < log.position_m.size(); ++i) log.position_m[i] += 40e-6;
    const Diagnosis is = diagnosed(log);
    ASSERT_TRUE(is.unexplained);
    EXPECT_EQ(is.unexplained->coordinate, Coordinate::time);
    EXPECT_NEAR(is.unexplained->where, static_cast<double>(at) / log.sample_rate_Hz, 1e-3);
    EXPECT_EQ(is.verdict, payload_share > 0.0 ? Verdict::missing_effect : Verdict::unexplained);
    const std::vector<std::string> hidden(payload_share > 0.0 ? 1 : 0, "payload_mass");
    EXPECT_EQ(added(is), hidden);
  }
}

TEST(Confounders, APayloadAndADelayAreNotNamedAMode) {
  sim::Bench bench = bench_of(33);
  bench.axis.effects.payload_kg = 0.2 * bench.axis.mass_kg;
  bench.axis.effects.delay = sim::RecordingDelay{2e-3, 0.0};
  EXPECT_EQ(added(diagnosed(test::simulate(bench, 33))),
            (std::vector<std::string>{"payload_mass", "time_delay"}));
}

// The virgin curve of this axis starts with infinite stiffness: within one encoder step there is a force that
// changes with the sign of velocity, as Coulomb friction does. Its controller creeps and reverses within a
// few encoder steps.
TEST(Confounders, ASteepVirginCurveIsNotNamedCoulombFriction) {
  constexpr std::uint64_t kSeed = 61005;
  const sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, kSeed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, kSeed);
  const Log log =
      test::log_of(bench.axis, sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, kSeed));
  const Diagnosis is = diagnosed(log);
  EXPECT_EQ(is.verdict, Verdict::complete)
      << is.steps.back().effect << "; " << (is.unexplained ? is.unexplained->description : "");
}

// Friction that differs from any sum of stop operators, in motion of one frequency: whatever else fits, a
// mode of many times the mass of the axis must not be named.
TEST(Confounders, AnArmHeavierThanItsAxisIsNotNamed) {
  test::Draw draw(5);
  const auto x = [](double t) {
    return 4e-5 * (std::sin(kTwoPi * 0.5 * t) + 0.6 * std::sin(kTwoPi * 1.3 * t));
  };
  double lagging_N = 0.0;
  Log log = test::log_of(1000.0, 20000, x, [&](double t) {
    // Follows the displacement with a time constant near that of the motion.
    lagging_N += 1e-3 / 0.3 * (2e5 * x(t) - lagging_N);
    return lagging_N + 0.02 * draw.normal();
  });
  log.mass_kg = 10.0;
  log.encoder_resolution_m = 1e-9;
  const Diagnosis is = diagnosed(log);
  const Term* mode = find_term(is.explained.terms, "structural_resonance");
  if (mode != nullptr && std::abs(mode->gains[0]) > 50.0) {
    EXPECT_EQ(is.verdict, Verdict::unexplained);
  }
  EXPECT_NE(is.verdict, Verdict::complete);
}

/// The verdict on viscous friction as the explanation of a friction that grows with acceleration, which was
/// refused. `refused_N`: what it leaves, in place of what its fit leaves.
Diagnosis judged_beside_refused(const std::function<double(double)>& refused_N) {
  test::Draw draw(7);
  const auto wave = [](double t, auto&& of) {
    return of(0.02, 4.4, t) + of(0.004, 19.5, t) + of(0.0006, 40.0, t);
  };
  const auto x = [&](double t) {
    return wave(t, [](double a, double w, double s) { return a * std::sin(w * s + w); });
  };
  Log log = test::log_of(1000.0, 20000, x, [&](double t) {
    const double v = wave(t, [](double a, double w, double s) { return a * w * std::cos(w * s + w); });
    const double acceleration =
        -wave(t, [](double a, double w, double s) { return a * w * w * std::sin(w * s + w); });
    const double dry_N = std::tanh(v / 1e-4) * (1.0 + 0.5 * std::abs(acceleration));
    return 50.0 * acceleration + dry_N + 6.0 * v + 0.02 * draw.normal();
  });
  log.mass_kg = 50.0;
  log.encoder_resolution_m = 1e-9;
  Measurement measurement(log);
  weigh_rows(measurement);
  const auto fitted_with = [&](const std::vector<std::string>& effects) {
    return fit_effects(measurement, effects, {});
  };
  Diagnosis is;
  is.baseline = fitted_with({"inertia", "coulomb"});
  is.explained = fitted_with({"inertia", "coulomb", "viscous"});
  const FittedModel refused = fitted_with({"inertia", "coulomb", "acceleration_dependent_preload"});
  is.noise_floor_N = measurement.noise_floor_N();
  is.steps.resize(2);
  is.candidates.resize(1);
  is.candidates[0].term = *find_term(refused.terms, "acceleration_dependent_preload");
  is.candidates[0].terms = refused.terms;
  is.candidates[0].holdout_rmse_N = refused_N(is.explained.holdout_rmse_N);
  is.candidates[0].error_reduction = 1.0 - is.candidates[0].holdout_rmse_N / is.baseline.holdout_rmse_N;
  is.candidates[0].criterion_difference = -100.0;
  judge(measurement, is);
  return is;
}

TEST(Confounders, ARefusedEffectThatIsFarBetterAloneTakesTheNamesAway) {
  const Diagnosis far = judged_beside_refused([](double named_N) { return 0.5 * named_N; });
  EXPECT_EQ(far.verdict, Verdict::unexplained);
  ASSERT_TRUE(far.unexplained.has_value());
  EXPECT_NE(far.unexplained->description.find("acceleration_dependent_preload alone would lower the error"),
            std::string::npos)
      << far.unexplained->description;
  EXPECT_EQ(judged_beside_refused([](double named_N) { return 0.8 * named_N; }).verdict,
            Verdict::missing_effect);
}

}  // namespace
}  // namespace slipstack::workbench
