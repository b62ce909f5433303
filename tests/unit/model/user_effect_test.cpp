// SPDX-License-Identifier: Apache-2.0
// A user-defined effect, from its text to the model file. The test adds the effect to the force of a
// simulated axis that shares no code with the workbench.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/estimate/simulated_axis.h"
#include "tests/unit/model/model_support.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/user_effect.h"
#include "workbench/model/expression/definition.h"

namespace slipstack::workbench::test {
namespace {

const std::string kSnag = "snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]";

struct Hidden {
  double level_N = 0.0;
  double place_m = 0.21;
  double width_m = 3e-3;
};

/// An axis with a place on its rail that rubs: dry friction over a short distance, smooth below 2 mm/s.
Log log_with(const Hidden& hidden, std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
  bench.programme.seconds = 30.0;
  bench.rate_Hz = 1000.0;
  sim::Rng motion(seed, "motion");
  const sim::MotionProgramme programme = sim::make_test_programme(bench.axis, bench.programme, motion);
  sim::SimulatedLog simulated = sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed);
  for (std::size_t i = 0; i < simulated.size(); ++i) {
    const sim::MotionPoint point = programme.at(simulated.time_s(i));
    const double u = (point.x_m - hidden.place_m) / hidden.width_m;
    simulated.force_N[i] += hidden.level_N * std::exp(-u * u) * std::tanh(point.v_mps / 2e-3);
  }
  return log_of(bench.axis, simulated);
}

Diagnosis diagnosed(const Log& log, const std::string& own) {
  Measurement measurement(log);
  weigh_rows(measurement);
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  if (!own.empty()) options.user_effects = {&declare_effect(own)};
  return diagnose(measurement, options);
}

TEST(UserEffectIn, IsNamedFirstWhereItIsHidden) {
  const Hidden hidden{.level_N = 4.0};
  const Diagnosis diagnosis = diagnosed(log_with(hidden, 3), kSnag);
  EXPECT_EQ(diagnosis.verdict, Verdict::missing_effect);
  ASSERT_FALSE(diagnosis.candidates.empty());
  const Candidate& first = diagnosis.candidates.front();
  ASSERT_EQ(first.term.id(), "snag");
  EXPECT_NEAR(first.term.gains[0], hidden.level_N, 0.05 * hidden.level_N);
  ASSERT_EQ(first.term.shapes.size(), 2u);
  EXPECT_NEAR(first.term.shapes[0], hidden.place_m, 0.1 * hidden.width_m);
  EXPECT_NEAR(std::abs(first.term.shapes[1]), hidden.width_m, 0.05 * hidden.width_m);
  EXPECT_LT(diagnosis.explained.holdout_rmse_N, 1.2 * diagnosis.noise_floor_N);
  EXPECT_GT(diagnosis.baseline.holdout_rmse_N, 1.3 * diagnosis.noise_floor_N);
  EXPECT_NE(first.evidence.find("w = "), std::string::npos) << first.evidence;
}

TEST(UserEffectIn, IsNotNamedWhereNothingIsHidden) {
  for (const std::uint64_t seed : {3u, 4u}) {
    const Diagnosis diagnosis = diagnosed(log_with({}, seed), kSnag);
    EXPECT_EQ(diagnosis.steps.size(), 1u) << seed;
    EXPECT_EQ(diagnosis.verdict, diagnosed(log_with({}, seed), "").verdict) << seed;
  }
}

TEST(UserEffectIn, SharesNoNameWithAnother) {
  EXPECT_EQ(&declare_effect("twice = A*x; A: N/m"), &declare_effect("twice = A*x; A: N/m"));
  EXPECT_THROW(declare_effect("twice = A*x^2; A: N/m2"), DefinitionError);
  EXPECT_THROW(declare_effect("viscous = A*v; A: N s/m"), DefinitionError);
  EXPECT_EQ(find_effect("twice")->definition, "twice = A*x; A: N/m");
  EXPECT_EQ(find_effect("never"), nullptr);
}

TEST(UserEffectIn, ReportsWhereItIsNotFinite) {
  const Log log = log_with({}, 5);
  const Measurement measurement(log);
  const EffectDescription& root = declare_effect("root = A*ln(x - 0.2); A: N");
  Term term = make_term(measurement, root);
  term.gains[0] = 1.0;
  try {
    evaluate_force(measurement, {term});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("effect 'root' is not a finite number at t ="),
              std::string::npos);
  }
}

Model model_with_snag() {
  std::mt19937_64 random(8);
  Model model;
  Term snag = random_term(declare_effect(kSnag), random, 0, true);
  snag.shapes = {0.21, 3e-3};
  snag.gains = {4.25};
  model.terms = {random_term(*find_effect("viscous"), random, 0, true), snag};
  model.target_terms = {random_term(*find_effect("viscous"), random, 0, false)};
  return model;
}

TEST(UserEffectIn, IsKeptByTheModelFile) {
  const TemporaryFile file;
  const Model written = model_with_snag();
  const Model read = read_model(file.write(to_toml(written)));
  ASSERT_EQ(read.terms.size(), 2u);
  EXPECT_EQ(read.terms[1].effect, written.terms[1].effect);
  EXPECT_EQ(read.terms[1].gains, written.terms[1].gains);
  EXPECT_EQ(read.terms[1].shapes, written.terms[1].shapes);
  EXPECT_EQ(to_toml(read), to_toml(written));
}

TEST(UserEffectIn, AWrongDefinitionInAModelFileIsRefused) {
  const TemporaryFile file;
  const std::string good = to_toml(model_with_snag());
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& described) {
    std::string text = good;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      read_model(file.write(text));
      ADD_FAILURE() << described;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(described), std::string::npos) << error.what();
    }
  };
  refused("w: m in [1e-4, 1e-2]", "w: m in [1e-2, 1e-4]", "reversed");
  refused("definition = ", "definitions = ", "definitions");
  refused("sign(v); A: N", "sign(v)*B; A: N", "unknown name 'B'");
  refused("snag = A", "snug = A", "of 'snug', not of 'snag'");
}

}  // namespace
}  // namespace slipstack::workbench::test
