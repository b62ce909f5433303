// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/noise_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/draw.h"

namespace slipstack::workbench {
namespace {

/// A smooth signal with noise of 0.3, and a constant from `first` to `end`.
std::vector<double> signal_with_constant(std::size_t first, std::size_t end) {
  slipstack::test::Draw draw(11);
  std::vector<double> signal(20'000);
  for (std::size_t i = 0; i < signal.size(); ++i)
    signal[i] = 40.0 * std::sin(1e-3 * static_cast<double>(i)) + 0.3 * draw.normal();
  for (std::size_t i = first; i < end; ++i) signal[i] = 40.0;
  return signal;
}

TEST(WhiteNoise, IsWhatWasAdded) {
  EXPECT_NEAR(white_noise(signal_with_constant(0, 0)), 0.3, 0.01);
  EXPECT_EQ(white_noise(std::vector<double>(6, 1.0)), 0.0);
}

TEST(WhiteNoise, OfTheRestWhereAnIntervalIsLeftOut) {
  const std::vector<double> signal = signal_with_constant(4000, 16'000);
  EXPECT_EQ(white_noise(signal), 0.0);
  EXPECT_NEAR(white_noise(signal, {{4000, 16'000}}), 0.3, 0.01);
  // No difference reaches into what is left out.
  std::vector<double> broken = signal_with_constant(0, 0);
  for (std::size_t i = 7; i < broken.size(); i += 15) broken[i] = 1e6;
  std::vector<Interval> faults;
  for (std::size_t i = 7; i < broken.size(); i += 15) faults.push_back({i, i + 1});
  EXPECT_GT(white_noise(broken), 0.6);
  EXPECT_NEAR(white_noise(broken, faults), 0.3, 0.02);
}

/// A slow signal with noise, read in steps.
std::vector<double> quantised(double step, double noise) {
  slipstack::test::Draw draw(12);
  std::vector<double> signal(20'000);
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const double value = 40.0 * std::sin(1e-3 * static_cast<double>(i)) + noise * draw.normal();
    signal[i] = step * std::round(value / step);
  }
  return signal;
}

// Where noise is small against a step, most samples are equal to their neighbours, and differences alone
// would say that there is no error.
TEST(NoiseOfSamples, IsNoLessThanTheErrorOfTheSteps) {
  for (const double noise : {0.0, 0.05, 0.2}) {
    const std::vector<double> coarse = quantised(2.0, noise);
    EXPECT_EQ(white_noise(coarse), 0.0);
    EXPECT_NEAR(coarse_step(coarse), 2.0, 1e-9);
    EXPECT_NEAR(noise_of_samples(coarse), 2.0 / std::sqrt(12.0), 1e-3);
  }
  // One sample that was interpolated is not the step.
  std::vector<double> repaired = quantised(2.0, 0.05);
  repaired[500] += 0.01;
  EXPECT_NEAR(coarse_step(repaired), 2.0, 1e-9);
}

TEST(NoiseOfSamples, IsTheWhiteNoiseWhereThatIsLarger) {
  const std::vector<double> dithered = quantised(0.02, 0.3);
  EXPECT_NEAR(noise_of_samples(dithered), 0.3, 0.01);
  const std::vector<double> fine = signal_with_constant(0, 0);
  EXPECT_EQ(coarse_step(fine), 0.0);
  EXPECT_EQ(noise_of_samples(fine), white_noise(fine));
  // A command that stands still for half of the time has no steps.
  EXPECT_EQ(coarse_step(signal_with_constant(4000, 16'000)), 0.0);
}

TEST(NoiseOfSamples, GrowsAtHalfRateUnlessItIsWhite) {
  const std::vector<double> white = signal_with_constant(0, 0);
  EXPECT_NEAR(growth_of_noise_at_half_rate(white), 1.0, 0.05);
  std::vector<double> interpolated(white.size());  // from every third sample
  for (std::size_t i = 0; i + 3 < white.size(); ++i) {
    const std::size_t from = i / 3 * 3;
    const double share = static_cast<double>(i - from) / 3.0;
    interpolated[i] = (1.0 - share) * white[from] + share * white[from + 3];
  }
  EXPECT_GT(growth_of_noise_at_half_rate(interpolated), 1.2);
  EXPECT_EQ(growth_of_noise_at_half_rate(std::vector<double>(100, 1.0)), 1.0);
  EXPECT_EQ(growth_of_noise_at_half_rate(quantised(1.9, 0.05)), 1.0);  // differences that are rounding
}

}  // namespace
}  // namespace slipstack::workbench
