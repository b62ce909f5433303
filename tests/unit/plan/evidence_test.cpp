// SPDX-License-Identifier: Apache-2.0
// The evidence that a plan promises, against the evidence that is found when the plan is run on simulated
// axes, which share no friction code with the planner.
#include <gtest/gtest.h>

#include <cmath>

#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/motion/programme.h"
#include "sim_host/motion/set_points.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/plan/known_axis.h"
#include "workbench/plan/limits.h"

namespace slipstack::workbench {
namespace {

/// How much the effect lowers the criterion of the baseline, both fitted to the log.
double evidence_found(const Log& log, const std::string& effect) {
  Measurement measurement(log);
  weigh_rows(measurement);
  const std::vector<std::string> baseline{"inertia", "presliding_hysteresis"};
  std::vector<std::string> more = baseline;
  more.push_back(effect);
  const FittedModel without = fit_effects(measurement, baseline, {});
  const FittedModel with = fit_effects(measurement, more, {});
  const std::size_t choices = choices_of(measurement, DiagnoseOptions{}, without.terms);
  return Criterion(measurement, without.terms, choices).difference(without, with);
}

struct Promise {
  double of_log = 0.0;   ///< expected of the log in hand
  double in_log = 0.0;   ///< found there
  double of_plan = 0.0;  ///< expected of the plan
  double in_plan = 0.0;  ///< found when it is run
};

Promise promised_and_found(sim::EffectId effect, std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  bench.programme.seconds = 20.0;
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  sim::add_effects(bench.axis, {effect}, programme, bench.rate_Hz, 6.0, seed);
  const std::string id(sim::name(effect));
  const Log first = test::log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed));
  Progress progress([](const std::string&, double) {});
  PlanRequest request;
  request.effects = id;
  request.logs = {"first"};
  request.in_memory = {{"first", first}};
  request.seconds = 30.0;
  request.rate_Hz = bench.rate_Hz;
  const KnownAxis known = known_axis(request, {id}, progress);
  const Plan plan =
      plan_experiment(known.knowledge, {.limits = limits_of_axis({}, known.reached, std::nullopt),
                                        .seconds = 30.0,
                                        .in_hand = {},
                                        .progress = {}});
  sim::MotionProgramme planned;
  planned.append(sim::make_sampled(plan.motion.position_m, plan.motion.rate_Hz));
  const Log second =
      test::log_of(bench.axis, sim::simulate_log(bench.axis, planned, bench.rate_Hz, seed + 1));
  return {known.evidence_in_hand(plan.effects).front().evidence, evidence_found(first, id),
          plan.expected.front().evidence, evidence_found(second, id)};
}

// The expectation is right within a factor of 2.5 on these axes, which is all that a choice between motions
// needs: it assumes the strength and the scatter that one log shows.
TEST(ExpectedEvidence, IsWhatTheMotionsShow) {
  struct Case {
    sim::EffectId effect;
    std::uint64_t seed;
  };
  for (const Case& one :
       {Case{sim::EffectId::kViscous, 2}, Case{sim::EffectId::kViscous, 5},
        Case{sim::EffectId::kQuadraticDrag, 4}, Case{sim::EffectId::kCableChainStiffness, 7},
        Case{sim::EffectId::kForceRipple, 1}, Case{sim::EffectId::kStribeck, 8}}) {
    const Promise found = promised_and_found(one.effect, one.seed);
    SCOPED_TRACE(std::string(sim::name(one.effect)) + " " + std::to_string(one.seed));
    EXPECT_GT(found.in_plan, kDecisive);
    EXPECT_NEAR(std::log2(found.of_plan / found.in_plan), 0.0, std::log2(2.5));
    EXPECT_NEAR(found.of_log / found.in_log, 1.0, 0.1);
  }
}

}  // namespace
}  // namespace slipstack::workbench
