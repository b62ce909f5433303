// SPDX-License-Identifier: Apache-2.0
// The effect that docs/adding-an-effect.md adds: known to the catalogue, right in its formula, part of the
// model that the controller runs, and named where it is hidden. This file is compiled with the page's code in
// front of the catalogue.
#include "firmware/effects/catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "firmware/effects/model.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "workbench/c_export/friction_header.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack {
namespace {

constexpr double kPeak_N = 4.0;
constexpr double kCritical_mps = 0.15;

double brake_N(double velocity_mps) {
  const double ratio = velocity_mps / kCritical_mps;
  return kPeak_N * 2.0 * ratio / (1.0 + ratio * ratio);
}

/// What the simulated axis feels besides: the brake, from where it truly is.
void add_brake(sim::SimulatedLog& log) {
  for (std::size_t i = 1; i + 1 < log.size(); ++i) {
    const double velocity_mps = 0.5 * log.rate_Hz * (log.true_position_m[i + 1] - log.true_position_m[i - 1]);
    log.force_N[i] += brake_N(velocity_mps);
  }
}

workbench::Log log_with_brake(std::uint64_t seed) {
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, seed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  sim::SimulatedLog simulated = sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed);
  add_brake(simulated);
  workbench::Log log;
  log.sample_rate_Hz = simulated.rate_Hz;
  log.position_m = simulated.position_m;
  log.force_N = simulated.force_N;
  log.mass_kg = bench.axis.mass_kg;
  log.encoder_resolution_m = bench.axis.encoder_resolution_m;
  return log;
}

TEST(AddingAnEffect, TheCatalogueEndsWithIt) {
  EXPECT_EQ(workbench::catalogue().back().id(), "eddy_current_brake");
  EXPECT_NE(workbench::find_effect("eddy_current_brake"), nullptr);
}

// Its header states no traits: the defaults make it an effect like most.
TEST(AddingAnEffect, ItIsNoSpecialEffect) {
  const workbench::EffectDescription& brake = workbench::catalogue().back();
  EXPECT_TRUE(brake.has_role(Role::none));
  EXPECT_TRUE(brake.is_plannable());
  EXPECT_FALSE(brake.traits.in_default_baseline || brake.traits.per_log ||
               brake.traits.plausible.least_share_of_force > 0.0);
}

TEST(AddingAnEffect, TheControllerRunsIt) {
  FrictionModel<float>::Parameters parameters;
  auto& own = std::get<EffectParameters<EddyCurrentBrake<float>, float>>(parameters);
  own.enabled = true;
  own.gains = {static_cast<float>(kPeak_N)};
  own.shapes = {static_cast<float>(kCritical_mps)};
  FrictionModel<float> model;
  model.prepare(parameters, {.tick_s = 1.0e-4F, .metres_per_displacement = 1.0e-6F});
  for (const double velocity_mps : {-2.0, -0.15, -0.01, 0.0, 0.001, 0.15, 0.3, 5.0}) {
    Sample<float> sample;
    sample.velocity_mps = static_cast<float>(velocity_mps);
    EXPECT_NEAR(static_cast<double>(model.step(sample).total_N), brake_N(velocity_mps), 1e-5) << velocity_mps;
  }
}

// Its C text is recorded from the header on the page: there is none to write.
TEST(AddingAnEffect, TheExportHasIt) {
  workbench::Model model;
  workbench::Term term;
  term.effect = &workbench::catalogue().back();
  term.gains = {kPeak_N};
  term.shapes = {kCritical_mps};
  model.target_terms = {term};
  const std::string header = workbench::friction_header(model, {});
  EXPECT_NE(header.find("const float eddy_current_brake_N = 4.0F * "), std::string::npos) << header;
  EXPECT_NE(header.find("motion->velocity_mps"), std::string::npos) << header;
}

TEST(AddingAnEffect, TheDiagnosisNamesIt) {
  workbench::Measurement measurement(log_with_brake(1));
  workbench::weigh_rows(measurement);
  workbench::DiagnoseOptions options;
  options.baseline = workbench::default_baseline();
  const workbench::Diagnosis diagnosis = workbench::diagnose(measurement, options);
  ASSERT_EQ(diagnosis.verdict, workbench::Verdict::missing_effect);
  const workbench::Candidate& first = diagnosis.candidates.front();
  EXPECT_EQ(first.term.id(), "eddy_current_brake");
  EXPECT_NEAR(first.term.gains[0], kPeak_N, 0.05 * kPeak_N);
  EXPECT_NEAR(first.term.shapes[0], kCritical_mps, 0.05 * kCritical_mps);
  const std::size_t unit = first.evidence.find(" mm/s, where it is ");
  ASSERT_NE(unit, std::string::npos) << first.evidence;
  EXPECT_NE(first.evidence.substr(0, unit).find(" +- "), std::string::npos) << first.evidence;
  EXPECT_LT(diagnosis.best.holdout_rmse_N, 1.3 * diagnosis.noise_floor_N);
  EXPECT_GT(diagnosis.best.holdout_rmse_N, 0.5 * diagnosis.noise_floor_N);
}

}  // namespace
}  // namespace slipstack
