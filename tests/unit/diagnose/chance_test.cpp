// SPDX-License-Identifier: Apache-2.0
// What chance can do: the rate of false differences, and differences that are seen.
#include "workbench/diagnose/evidence/chance.h"

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
    std::vector<double> observations(30);
    for (double& observation : observations) observation = mean + draw.normal();
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

// One log of 32 has five jumps of one sign without a reason (two-sided 6 %, one-sided 3 %).
TEST(EqualSigns, AreChanceUpToFour) {
  EXPECT_TRUE(equal_signs_are_chance(4));
  EXPECT_FALSE(equal_signs_are_chance(5));
}

TEST(IsChance, AllowsForWhatWasTried) {
  EXPECT_FALSE(is_chance(0.001, 10.0));
  EXPECT_TRUE(is_chance(0.001, 100.0));
}

}  // namespace
}  // namespace slipstack::workbench
