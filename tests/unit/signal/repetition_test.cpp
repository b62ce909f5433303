// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/repetition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Three harmonics with this period, and noise.
std::vector<double> periodic(double period, std::size_t count, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, kTwoPi);
  const double phases[] = {uniform(random), uniform(random), uniform(random)};
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    double value = noise * normal(random);
    for (int h = 1; h <= 3; ++h)
      value += std::sin(kTwoPi * h * static_cast<double>(i) / period + phases[h - 1]) / h;
    values.push_back(value);
  }
  return values;
}

TEST(RepetitionPeriod, IsFoundToAFractionOfASample) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const double period = 73.0 + 11.37 * static_cast<double>(seed);
    EXPECT_NEAR(repetition_period(periodic(period, 1500, 0.02, seed)), period, 2e-4 * period) << seed;
  }
}

TEST(RepetitionPeriod, IsZeroOfWhatDoesNotRepeat) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> wandering(2000, 0.0);
  double slow = 0.0;
  for (double& value : wandering) value = slow = 0.97 * slow + normal(random);
  EXPECT_EQ(repetition_period(wandering), 0.0);
  EXPECT_EQ(repetition_period(periodic(800.0, 2000, 0.0, 4)), 0.0);  // two and a half times
  EXPECT_EQ(repetition_period(periodic(100.0, 2000, 0.5, 5)), 0.0);  // too different
  EXPECT_EQ(repetition_period(std::vector<double>(2000, 1.0)), 0.0);
  EXPECT_EQ(repetition_period({}), 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
