// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling/encoder_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace slipstack::workbench::test {
namespace {

constexpr double kRounding_m = 1e-16;

std::vector<double> quantised(std::vector<double> positions, double step_m) {
  for (double& x : positions) x = std::round(x / step_m) * step_m;
  return positions;
}

// A motion of two sines with the total amplitude `amplitude_m`; `speed` in radians per sample.
std::vector<double> motion(std::size_t count, double amplitude_m, double speed) {
  std::vector<double> positions(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double phase = speed * static_cast<double>(i);
    positions[i] = amplitude_m * (0.7 * std::sin(phase) + 0.3 * std::sin(2.3 * phase + 0.4));
  }
  return positions;
}

// From slow motions, where most samples repeat the one before, to thousands of steps per sample.
TEST(EncoderStep, IsFoundWhateverTheSpeed) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> log_step(std::log(1e-9), std::log(1e-5));
  std::uniform_real_distribution<double> log_speed(std::log(0.05), std::log(3000.0));
  int found = 0;
  constexpr int kRounds = 300;
  for (int round = 0; round < kRounds; ++round) {
    const double step_m = std::exp(log_step(random));
    const double steps_per_sample = std::exp(log_speed(random));
    const double amplitude_m = std::max(100.0, 50.0 * steps_per_sample) * step_m;
    const auto positions =
        quantised(motion(20'000, amplitude_m, steps_per_sample * step_m / amplitude_m), step_m);
    const auto estimate = estimate_encoder_step(positions, 1e-12 * step_m + 4e-16 * amplitude_m);
    if (estimate && std::abs(*estimate / step_m - 1.0) < 1e-4) ++found;
  }
  EXPECT_GE(found, kRounds * 99 / 100);
}

TEST(EncoderStep, IsRoundWhereTheEncoderIs) {
  for (const double step_m : {1e-6, 1e-7, 5e-8, 2e-7, 1.25e-6, 1e-8}) {
    const auto estimate = estimate_encoder_step(quantised(motion(5000, 1e-2, 1e-3), step_m), kRounding_m);
    ASSERT_TRUE(estimate) << step_m;
    EXPECT_DOUBLE_EQ(*estimate, step_m);
  }
}

// One sample in four hundred lies half-way between its neighbours, as loggers fill in lost samples.
TEST(EncoderStep, IsNotHalvedByInterpolatedSamples) {
  auto positions = quantised(motion(20'000, 1e-4, 1e-3), 1e-7);
  for (std::size_t i = 100; i + 1 < positions.size(); i += 400) {
    positions[i] = 0.5 * (positions[i - 1] + positions[i + 1]);
  }
  const auto estimate = estimate_encoder_step(positions, kRounding_m);
  ASSERT_TRUE(estimate);
  EXPECT_DOUBLE_EQ(*estimate, 1e-7);
}

TEST(EncoderStep, IsAbsentWithoutAnEncoder) {
  EXPECT_FALSE(estimate_encoder_step(motion(5000, 1e-2, 1e-3), kRounding_m));
  EXPECT_FALSE(estimate_encoder_step(motion(200, 1e-3, 1e-3), kRounding_m));
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal(0.0, 1e-6);
  std::vector<double> noise(5000);
  for (double& x : noise) x = normal(random);
  EXPECT_FALSE(estimate_encoder_step(noise, kRounding_m));
}

// At constant speed a smooth position changes by the same amount in each sample; that is no encoder step.
TEST(EncoderStep, IsAbsentInASmoothTraverse) {
  std::vector<double> traverse(1000);
  for (std::size_t i = 0; i < traverse.size(); ++i) traverse[i] = 1.7e-5 * static_cast<double>(i);
  EXPECT_FALSE(estimate_encoder_step(traverse, 1e-16));
}

TEST(EncoderStep, NeedsSomeChanges) {
  std::vector<double> positions(1000, 0.0);
  for (std::size_t i = 0; i < 9; ++i) positions[100 * (i + 1)] = 1e-6;  // 18 changes
  EXPECT_TRUE(estimate_encoder_step(positions, kRounding_m));
  std::fill(positions.begin() + 450, positions.end(), 0.0);  // 8 changes
  EXPECT_FALSE(estimate_encoder_step(positions, kRounding_m));
}

// Positions stored in single precision: the step is found where it is larger than their rounding, else none.
TEST(EncoderStep, IsAbsentWhereStorageRoundingHidesIt) {
  const auto stored = [](double step_m) {
    auto positions = quantised(motion(20'000, 0.3, 2e-6), step_m);
    for (double& x : positions) x = static_cast<double>(static_cast<float>(x));
    return estimate_encoder_step(positions, 0x1p-23 * 0.3);
  };
  const auto coarse = stored(1e-5);
  ASSERT_TRUE(coarse);
  EXPECT_NEAR(*coarse, 1e-5, 2e-8);
  EXPECT_FALSE(stored(1e-7));
}

}  // namespace
}  // namespace slipstack::workbench::test
