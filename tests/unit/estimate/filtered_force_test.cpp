// SPDX-License-Identifier: Apache-2.0
// A force that was low-passed alone is recognised, with the frequency; one as a sensor gives it is not.
#include "workbench/estimate/nonlinear/filtered_force.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

constexpr int kPasses = 4;

/// A first-order low pass four times forward and four times backward: zero phase, 1 / (1 + (f / pole)^2)^4.
void low_pass(std::vector<double>& force_N, double rate_Hz, double pole_Hz) {
  const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * pole_Hz / rate_Hz);
  for (int pass = 0; pass < 2 * kPasses; ++pass) {
    double state = force_N.front();
    for (double& force : force_N) force = state += share * (force - state);
    std::reverse(force_N.begin(), force_N.end());
  }
}

std::optional<ForceFilter> filter_of(Log log) {
  Measurement measurement(std::move(log));
  weigh_rows(measurement);
  return filter_of_force(measurement);
}

Log axis(std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  bench.programme.seconds = 40.0;
  return test::simulate(bench, seed);
}

TEST(FilteredForce, IsRecognisedWithItsFrequency) {
  int recognised = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    Log log = axis(seed);
    EXPECT_FALSE(filter_of(log));
    const double half_Hz = 8.0;
    const double pole_Hz = half_Hz / std::sqrt(std::pow(2.0, 1.0 / kPasses) - 1.0);
    low_pass(log.force_N, log.sample_rate_Hz, pole_Hz);
    const auto filter = filter_of(log);
    if (!filter) continue;
    ++recognised;
    EXPECT_NEAR(filter->cut_Hz / half_Hz, 1.0, 0.15);
    EXPECT_GT(std::pow(1.0 + std::pow(filter->flat_Hz / pole_Hz, 2), -kPasses), 0.93);
    EXPECT_GT(filter->flat_Hz, 0.1 * half_Hz);
  }
  EXPECT_GE(recognised, 3);
}

// Where the noise is given, so is what the user knows of the sensor.
TEST(FilteredForce, IsNotLookedForWhereTheNoiseIsGiven) {
  Log log = axis(1);
  low_pass(log.force_N, log.sample_rate_Hz, 18.0);
  Measurement measurement(std::move(log), {.force_noise_N = 0.1});
  weigh_rows(measurement);
  EXPECT_FALSE(filter_of_force(measurement));
}

}  // namespace
}  // namespace slipstack::workbench
