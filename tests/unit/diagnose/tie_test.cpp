// SPDX-License-Identifier: Apache-2.0
// What chance can do: the rate of false differences, and differences that are seen.
#include "workbench/diagnose/evidence/tie.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/draw.h"

namespace slipstack::workbench {
namespace {

/// The share of experiments of 30 observations with this mean and unit variance that are called chance.
double called_chance(double mean) {
  constexpr int kExperiments = 4000;
  slipstack::test::Draw draw(17);
  int chance = 0;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    std::vector<double> observations;
    for (int i = 0; i < 30; ++i) observations.push_back(mean + draw.normal());
    chance += mean_is_chance(observations) ? 1 : 0;
  }
  return static_cast<double>(chance) / kExperiments;
}

// Student's t of 29 degrees of freedom is within 2.0 with a probability of 0.945.
TEST(MeanIsChance, InNineteenOfTwentyWithoutAMean) {
  EXPECT_NEAR(called_chance(0.0), 0.945, 0.012);
}

// The power of the test at one standard deviation: t with noncentrality sqrt(30) is above 2 nearly always.
TEST(MeanIsChance, NotOfAMeanOfOneStandardDeviation) {
  EXPECT_LT(called_chance(1.0), 0.01);
}

TEST(MeanIsChance, OfOneStrongObservation) {
  std::vector<double> observations(30, 0.0);
  observations[7] = 100.0;
  EXPECT_TRUE(mean_is_chance(observations));
  EXPECT_FALSE(mean_is_chance(std::vector<double>(30, 1e-3)));
  EXPECT_TRUE(mean_is_chance(std::vector<double>(1, 5.0)));
}

TEST(WithinChance, IsSymmetricAndSeesASmallDifferenceOfEveryBlock) {
  slipstack::test::Draw draw(5);
  std::vector<double> one, other, worse;
  for (int b = 0; b < 30; ++b) {
    const double block = draw.uniform(1.0, 10.0);
    one.push_back(block);
    other.push_back(block + 0.3 * draw.normal());
    worse.push_back(block * 1.02);
  }
  EXPECT_TRUE(within_chance(one, other));
  EXPECT_TRUE(within_chance(other, one));
  EXPECT_FALSE(within_chance(one, worse));
  EXPECT_FALSE(within_chance(worse, one));
}

}  // namespace
}  // namespace slipstack::workbench
