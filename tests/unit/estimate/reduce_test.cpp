// SPDX-License-Identifier: Apache-2.0
// From the many elements of the identification to the few of the controller.
#include "workbench/estimate/nonlinear/reduce.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"

namespace slipstack::workbench {
namespace {

const Term& hysteresis_of(const FittedModel& fitted) {
  return *find_term(fitted.terms, "presliding_hysteresis");
}

std::size_t elements_of(const Term& term) {
  std::size_t used = 0;
  for (const double gain : term.gains) used += gain > 0.0 ? 1 : 0;
  return used;
}

/// Force on the virgin curve.
double virgin_N(const Term& term, double travel_m) {
  double force = 0.0;
  for (std::size_t i = 0; i < term.gains.size(); ++i) {
    force += term.gains[i] * std::min(term.shapes[i], travel_m);
  }
  return force;
}

struct Case {
  Measurement measurement;
  FittedModel fitted;
  FittedModel reduced;
};
Case reduced_case(sim::Setup setup, std::uint64_t seed) {
  const sim::Bench bench = sim::draw_bench(setup, seed);
  Measurement measurement(test::simulate(bench, seed));
  FittedModel fitted = fit_effects(measurement, {"inertia", "presliding_hysteresis"}, {});
  FittedModel reduced = reduce_hysteresis(measurement, fitted, kTargetElements);
  return {std::move(measurement), std::move(fitted), std::move(reduced)};
}

TEST(Reduce, KeepsTheHysteresisInTenElements) {
  double mean_cost = 0.0;
  double worst_cost = 0.0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Case c = reduced_case(seed < 2 ? sim::Setup::kPickAndPlace : sim::Setup::kRandom, seed);
    const Term& full = hysteresis_of(c.fitted);
    const Term& few = hysteresis_of(c.reduced);
    EXPECT_LE(elements_of(few), static_cast<std::size_t>(kTargetElements)) << seed;
    EXPECT_GE(elements_of(few), 4u) << seed;
    // Unused elements come last, as the controller's parameter block requires.
    for (std::size_t i = kTargetElements; i < few.gains.size(); ++i) {
      EXPECT_EQ(few.gains[i], 0.0);
      EXPECT_EQ(few.shapes[i], 0.0);
    }
    const double saturation_N = virgin_N(full, 1e-3);
    EXPECT_NEAR(virgin_N(few, 1e-3) / saturation_N, 1.0, 0.01) << seed;
    for (double travel_m = 1e-6; travel_m < 1e-3; travel_m *= 1.5) {
      EXPECT_NEAR(virgin_N(few, travel_m), virgin_N(full, travel_m), 0.04 * saturation_N)
          << seed << ' ' << travel_m;
    }
    const double cost = c.reduced.holdout_rmse_N / c.fitted.holdout_rmse_N - 1.0;
    mean_cost += cost / 4.0;
    worst_cost = std::max(worst_cost, cost);
  }
  // Held-out error; the larger part where the encoder is fine and the force clean.
  EXPECT_LT(mean_cost, 0.1);
  EXPECT_GT(mean_cost, 0.01);
  EXPECT_LT(worst_cost, 0.2);
}

// The controller counts encoder steps: a slip distance between two counts would be rounded there, and with it
// the level that was fitted.
TEST(Reduce, SlipDistancesAreWholeSteps) {
  const Case c = reduced_case(sim::Setup::kPickAndPlace, 5);
  const double step_m = c.measurement.encoder_resolution_m();
  ASSERT_GT(step_m, 0.0);
  const Term& few = hysteresis_of(c.reduced);
  double previous = 0.0;
  for (std::size_t i = 0; i < elements_of(few); ++i) {
    const double steps = few.shapes[i] / step_m;
    EXPECT_GE(steps, 1.0 - 1e-9);
    EXPECT_NEAR(steps, std::round(steps), 1e-6) << i;
    EXPECT_GT(steps, previous + 0.5) << "two elements of one slip distance are one";
    previous = steps;
  }
}

TEST(Reduce, LeavesAFittingModelUnchanged) {
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 6);
  const Measurement measurement(test::simulate(bench, 6));
  const FittedModel plain = fit_effects(measurement, {"inertia", "viscous", "coulomb"}, {});
  const FittedModel same = reduce_hysteresis(measurement, plain, kTargetElements);
  EXPECT_EQ(same.holdout_rmse_N, plain.holdout_rmse_N);
  ASSERT_EQ(same.terms.size(), plain.terms.size());
  for (std::size_t t = 0; t < plain.terms.size(); ++t) EXPECT_EQ(same.terms[t].gains, plain.terms[t].gains);
}

TEST(Reduce, FewerElementsCostMore) {
  const sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, 7);
  const Measurement measurement(test::simulate(bench, 7));
  const FittedModel fitted = fit_effects(measurement, {"inertia", "presliding_hysteresis"}, {});
  const double two_N = reduce_hysteresis(measurement, fitted, 2).holdout_rmse_N;
  const double four_N = reduce_hysteresis(measurement, fitted, 4).holdout_rmse_N;
  const double ten_N = reduce_hysteresis(measurement, fitted, 10).holdout_rmse_N;
  EXPECT_GT(two_N, four_N);
  EXPECT_GT(four_N, ten_N);
  EXPECT_GT(two_N, 1.1 * ten_N);
}

}  // namespace
}  // namespace slipstack::workbench
