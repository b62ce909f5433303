// SPDX-License-Identifier: Apache-2.0
// What a search over several effects finds on random axes whose hidden effects mask each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/log/draw.h"
#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/diagnose/search/elimination_and_exchange.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

struct Result {
  std::vector<std::string> added;
  double error_over_floor;
};

Result found_on(std::uint64_t seed, const std::vector<sim::EffectId>& hidden) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  sim::add_effects(bench.axis, hidden, programme, bench.rate_Hz, 0.0, seed);
  const Diagnosis diagnosis = test::diagnosed(
      test::log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed)));
  Result result{{}, diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N};
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) result.added.push_back(diagnosis.steps[i].effect);
  std::sort(result.added.begin(), result.added.end());
  return result;
}

// The viscous force is thirty times the noise. Alone, on top of the baseline, a lag of 4 % of the friction
// does nothing, and the shapes that fit there best mean nothing.
TEST(Search, FindsAnEffectThatALargerOneHides) {
  const Result found = found_on(2026117006, {sim::EffectId::kViscous, sim::EffectId::kFrictionalLag});
  EXPECT_EQ(found.added, (std::vector<std::string>{"frictional_lag", "viscous"}));
  EXPECT_LT(found.error_over_floor, 1.1);
}

// The friction falls by a third in proportion to time: an exponential that ends within its bounds is another
// curve, and what it leaves takes the form of a lag.
TEST(Search, ADriftInProportionToTimeIsADriftAlone) {
  const Result found = found_on(2026117009, {sim::EffectId::kMotorConstantRipple, sim::EffectId::kDrift});
  EXPECT_EQ(found.added, (std::vector<std::string>{"drift", "motor_constant_ripple"}));
  EXPECT_LT(found.error_over_floor, 1.1);
}

/// What is left of viscous friction and a constant force, both of one gain, on a log with 5 N s/m and
/// `offset_N`.
std::vector<std::string> determined(double offset_N) {
  test::Draw draw(3);
  const auto x = [](double t) { return 0.02 * std::sin(6.0 * t) + 0.003 * std::sin(31.0 * t); };
  Log log = test::log_of(1000.0, 12000, x, [&](double t) {
    const double velocity_mps = 0.12 * std::cos(6.0 * t) + 0.093 * std::cos(31.0 * t);
    return 5.0 * velocity_mps + offset_N + 0.1 * draw.normal();
  });
  log.mass_kg = 0.0;
  Measurement measurement(log);
  weigh_rows(measurement);
  const FittedModel baseline = fit_effects(measurement, {"presliding_hysteresis"}, {});
  const SelectionContext context{measurement, baseline, Criterion(measurement, baseline.terms, 10)};
  Explanation explanation{{}, {"viscous", "offset_force"}};
  Terms terms = baseline.terms;
  for (const std::string& id : explanation.added) terms.push_back(make_term(measurement, *find_effect(id)));
  explanation.model = fit_gains(measurement, terms);
  drop_undetermined(context, explanation);
  return explanation.added;
}

TEST(DropUndetermined, WhatMayAsWellBeZeroBesideOthers) {
  EXPECT_EQ(determined(0.0), (std::vector<std::string>{"viscous"}));
  EXPECT_EQ(determined(0.5), (std::vector<std::string>{"viscous", "offset_force"}));
}

/// Whether an asymmetry of the level by `with_friction`, and by `with_motion` more once the axis moves, keeps
/// its name.
bool keeps_asymmetry(double with_friction, double with_motion) {
  Log log = test::wandering_log(5, 1000.0, 20'000);
  log.mass_kg = 0.0;
  Measurement measurement(log);
  Terms truth{make_term(measurement, *find_effect("coulomb")),
              make_term(measurement, *find_effect("direction_asymmetry"))};
  truth[0].gains = {10.0};
  truth[1].gains = {with_friction, with_motion, 0.0};
  const std::vector<double> force_N = evaluate_force(measurement, truth).force_N;
  test::Draw draw(6);
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 0.05 * draw.normal();
  measurement = Measurement(log);
  weigh_rows(measurement);
  const FittedModel baseline = fit_gains(measurement, {truth[0]});
  const SelectionContext context{measurement, baseline, Criterion(measurement, baseline.terms, 10)};
  Explanation explanation{fit_gains(measurement, truth), {"direction_asymmetry"}};
  drop_undetermined(context, explanation);
  return !explanation.added.empty();
}

// In steady motion the friction is the same both ways where the gains cancel; half a per cent of the level is
// what a hysteresis of another form leaves.
TEST(DropUndetermined, AnAsymmetryOfWhichNothingIsLeftInSteadyMotion) {
  EXPECT_FALSE(keeps_asymmetry(0.3, -0.3));
  EXPECT_FALSE(keeps_asymmetry(0.3, -0.302));
  EXPECT_TRUE(keeps_asymmetry(0.3, -0.28));
  EXPECT_TRUE(keeps_asymmetry(0.0, 0.05));
}

}  // namespace
}  // namespace slipstack::workbench
