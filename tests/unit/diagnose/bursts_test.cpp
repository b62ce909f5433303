// SPDX-License-Identifier: Apache-2.0
// A burst in the force is found wherever the axis is; fast moves, outliers and noise are not reported as one.
#include "workbench/diagnose/alternatives/bursts.h"

#include <gtest/gtest.h>

#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

constexpr double kRate_Hz = 1000.0;
constexpr std::size_t kSamples = 20000;
constexpr double kBurst_s = 7.3;

/// A log of slow and fast moves with noise in its force.
Log plain_log(std::uint64_t seed) {
  return test::wandering_log(seed, kRate_Hz, kSamples);
}

/// The burst that is found in a log.
std::optional<Structure> burst_of(const Log& log) {
  const Measurement measurement(log);
  return burst_in_force(measurement, std::vector<double>(log.force_N.size(), 0.0), measurement.force_N());
}

/// Adds noise of `amplitude_N` to `count` samples from `first_s`.
void add_burst(Log& log, double first_s, std::size_t count, double amplitude_N, std::uint64_t seed) {
  test::Draw draw(seed);
  const auto first = static_cast<std::size_t>(first_s * kRate_Hz);
  for (std::size_t i = first; i < first + count; ++i) log.force_N[i] += amplitude_N * draw.normal();
}

TEST(BurstInForce, IsReportedWithItsTimeAndDuration) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Log log = plain_log(seed);
    add_burst(log, kBurst_s, 60, 20.0, seed);
    const auto burst = burst_of(log);
    ASSERT_TRUE(burst) << seed;
    EXPECT_EQ(burst->coordinate, Coordinate::time);
    EXPECT_NEAR(burst->where, kBurst_s, 10e-3);
    EXPECT_NE(burst->description.find(" +- 1.0 ms at 7."), std::string::npos) << burst->description;
    // The part of the residual that it explains lies within it.
    EXPECT_GT(burst->explained_N.squaredNorm(), 0.0);
  }
}

TEST(BurstInForce, IsNotFoundInNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) EXPECT_FALSE(burst_of(plain_log(seed))) << seed;
}

TEST(BurstInForce, IsNotReportedWhereThereAreTwo) {
  Log log = plain_log(3);
  add_burst(log, 3.0, 60, 20.0, 1);
  add_burst(log, kBurst_s, 60, 20.0, 2);
  EXPECT_FALSE(burst_of(log));  // what comes again is no accident
}

TEST(BurstInForce, IsNotReportedForAFewOutliers) {
  Log log = plain_log(4);
  for (std::size_t i = 7300; i < 7304; ++i) log.force_N[i] += i % 2 == 0 ? 30.0 : -30.0;
  EXPECT_FALSE(burst_of(log));
}

// Reversals that follow quickly upon one another change the force from sample to sample, and the model's too.
TEST(BurstInForce, IsWhatTheModelDoesNotDo) {
  Log log = plain_log(6);
  add_burst(log, kBurst_s, 60, 20.0, 6);
  std::vector<double> model_N(log.force_N.size(), 0.0);
  const auto found = [&] {
    const Measurement measurement(log);
    return burst_in_force(measurement, model_N, measurement.force_N()).has_value();
  };
  EXPECT_TRUE(found());
  model_N = log.force_N;
  EXPECT_FALSE(found());
}

TEST(BurstInForce, IsNotReportedWhereTheAxisIsShaken) {
  Log log = plain_log(5);
  add_burst(log, kBurst_s, 100, 20.0, 5);
  EXPECT_TRUE(burst_of(log));
  for (std::size_t i = 7300; i < 7400; ++i) {
    const double rad = 2.0 * std::numbers::pi * 0.06 * static_cast<double>(i - 7300);
    log.position_m[i] += 2e-3 * std::sin(rad);
    log.force_N[i] += 2000.0 * std::sin(rad);
  }
  EXPECT_FALSE(burst_of(log));
}

}  // namespace
}  // namespace slipstack::workbench
