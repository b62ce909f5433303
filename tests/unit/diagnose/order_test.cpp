// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

// The result must not depend on the order of effects, nor on units.
namespace slipstack::workbench {
namespace {

using test::diagnosed;

Log plain_log() {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 1);
  bench.programme.seconds = 15.0;
  return test::simulate(bench, 21);
}

Log viscous_log() {
  Log log = plain_log();
  const Measurement motion(log);
  for (std::size_t i = 0; i < log.force_N.size(); ++i) log.force_N[i] += 12.0 * motion.velocity_mps()[i];
  return log;
}

TEST(Order, TheRankDoesNotDependOnTheCataloguesOrder) {
  const Log log = viscous_log();
  const Diagnosis usual = diagnosed(log, {});
  ASSERT_EQ(usual.candidates.front().term.id(), "viscous");
  std::vector<std::string> ids;
  for (const EffectDescription& effect : catalogue()) ids.push_back(effect.id());
  std::mt19937_64 random(3);
  for (int turn = 0; turn < 2; ++turn) {
    if (turn == 0) {
      std::reverse(ids.begin(), ids.end());
    } else {
      std::shuffle(ids.begin(), ids.end(), random);
    }
    const Diagnosis other = diagnosed(log, ids);
    EXPECT_EQ(other.verdict, usual.verdict);
    ASSERT_EQ(other.candidates.size(), usual.candidates.size());
    for (std::size_t i = 0; i < usual.candidates.size(); ++i) {
      EXPECT_EQ(other.candidates[i].term.id(), usual.candidates[i].term.id()) << i;
      EXPECT_EQ(other.candidates[i].holdout_rmse_N, usual.candidates[i].holdout_rmse_N) << i;
    }
  }
}

// What the excerpt of a long log names first stays first where another effect is better alone in the whole
// logs: the verdict, the first candidate and the first step are one effect.
TEST(Order, TheFirstStepStaysFirstWhateverWholeLogsSayOfTheOthers) {
  Log log = viscous_log();
  for (double& force_N : log.force_N) force_N += 2.0;
  Measurement measurement(log);
  weigh_rows(measurement);
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  options.candidates = {"stribeck", "viscous", "offset_force"};
  EffectSearch search(measurement, options);
  Diagnosis& found = search.diagnosis();
  ASSERT_EQ(found.steps.size(), 3U);
  const std::string first = found.steps[1].effect;
  for (Candidate& candidate : found.candidates) {
    if (candidate.term.id() == found.steps[2].effect)
      candidate.holdout_rmse_N = 0.5 * found.candidates.front().holdout_rmse_N;
  }
  const Diagnosis result = search.conclude();
  EXPECT_EQ(result.candidates.front().term.id(), first);
  EXPECT_EQ(result.steps[1].effect, first);
  EXPECT_TRUE(contains(result.best.terms, first));
}

// A payload that changes the mass to a thousandth of the declared one indicates a wrong unit; a payload of a
// few kilograms does not.
TEST(Order, AMassInGramsIsReportedAsAWrongUnit) {
  Log log = plain_log();
  const double mass_kg = log.mass_kg.value();
  log.mass_kg = 1e3 * mass_kg;
  const Diagnosis wrong = diagnosed(log, {});
  EXPECT_EQ(wrong.verdict, Verdict::unexplained);
  ASSERT_TRUE(wrong.unexplained);
  EXPECT_EQ(wrong.unexplained->coordinate, Coordinate::acceleration);
  EXPECT_NE(wrong.unexplained->description.find("check mass_kg"), std::string::npos)
      << wrong.unexplained->description;
  log.mass_kg = 0.01 * mass_kg;
  EXPECT_EQ(diagnosed(log, {}).verdict, Verdict::unexplained);
  log.mass_kg = 0.6 * mass_kg;
  const Diagnosis loaded = diagnosed(log, {});
  EXPECT_EQ(loaded.verdict, Verdict::missing_effect);
  EXPECT_EQ(loaded.candidates.front().term.id(), "payload_mass");
}

}  // namespace
}  // namespace slipstack::workbench
