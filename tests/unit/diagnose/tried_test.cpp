// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

// What is told while the search runs: every candidate of the result once, before the first further level, and
// of the effect that is missing nearly what the result says.
TEST(Tried, EveryCandidateIsToldBeforeTheSearchIsOver) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 1);
  bench.programme.seconds = 15.0;
  Log log = test::simulate(bench, 21);
  const Measurement motion(log);
  for (std::size_t i = 0; i < log.force_N.size(); ++i) log.force_N[i] += 12.0 * motion.velocity_mps()[i];
  Measurement measurement(log);
  weigh_rows(measurement);

  std::mutex lock;
  std::map<std::string, double> reduction;
  bool later_level = false;
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  options.candidates = {"stribeck", "viscous", "offset_force", "force_ripple"};
  options.tried = [&](const Trial& trial, double baseline_N) {
    const std::lock_guard held(lock);
    EXPECT_FALSE(later_level);
    EXPECT_TRUE(reduction.emplace(trial.term.id(), 1.0 - trial.holdout_rmse_N / baseline_N).second);
  };
  options.progress = [&](const std::string& stage, double) {
    const std::lock_guard held(lock);
    if (stage == "try every effect on top" || stage == "judge on unseen data") later_level = true;
  };
  const Diagnosis found = diagnose(measurement, options);
  EXPECT_TRUE(later_level);
  ASSERT_EQ(found.candidates.size(), reduction.size());
  for (const Candidate& candidate : found.candidates) EXPECT_EQ(reduction.count(candidate.term.id()), 1U);
  ASSERT_EQ(found.candidates.front().term.id(), "viscous");
  EXPECT_NEAR(reduction["viscous"], found.candidates.front().error_reduction, 0.03);
  EXPECT_GT(reduction["viscous"], 0.5);
  const auto largest = std::max_element(reduction.begin(), reduction.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  EXPECT_EQ(largest->first, "viscous");
}

// Candidates that lower the error by less than the table shows are as they were tried. Fitted in full they
// would lower it by no more.
TEST(Tried, WhatIsNotShownWouldNotBeShownFittedInFull) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
    bench.programme.seconds = 15.0;
    bench.axis.effects.payload_kg = 0.1 * bench.axis.mass_kg;
    Measurement measurement(test::simulate(bench, seed));
    const Diagnosis found = test::diagnosed(measurement);
    std::size_t shown = 0;
    for (const Candidate& candidate : found.candidates) {
      if (candidate.error_reduction >= kLeastShownReduction) {
        ++shown;
        EXPECT_NE(candidate.criterion_difference, 0.0) << seed << ' ' << candidate.term.id();
        continue;
      }
      EXPECT_EQ(candidate.criterion_difference, 0.0) << seed << ' ' << candidate.term.id();
      FittedModel model = fit_gains(measurement, candidate.terms);
      judge_on_unseen_data(measurement, model);
      EXPECT_GT(model.holdout_rmse_N, 0.99 * found.baseline.holdout_rmse_N)
          << seed << ' ' << candidate.term.id();
    }
    EXPECT_GE(shown, 1U) << seed;
    EXPECT_LT(shown, found.candidates.size()) << seed;
  }
}

}  // namespace
}  // namespace slipstack::workbench
