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

}  // namespace
}  // namespace slipstack::workbench
