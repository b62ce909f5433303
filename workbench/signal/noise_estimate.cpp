// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {

double white_noise(std::span<const double> signal, const std::vector<Interval>& left_out) {
  constexpr double kGain = 30.397368307141326;  // sqrt(924), 924 = sum of squares of (1 -6 15 -20 15 -6 1)
  std::vector<double> differences;
  differences.reserve(signal.size());
  auto next = left_out.begin();
  for (std::size_t i = 3; i + 3 < signal.size(); ++i) {
    while (next != left_out.end() && next->end + 3 <= i) ++next;
    if (next != left_out.end() && next->first <= i + 3) continue;
    const double d = (signal[i - 3] + signal[i + 3]) - 6.0 * (signal[i - 2] + signal[i + 2]) +
                     15.0 * (signal[i - 1] + signal[i + 1]) - 20.0 * signal[i];
    differences.push_back(std::abs(d));
  }
  if (differences.empty()) return 0.0;
  return median(std::move(differences)) / kMedianOfNormal / kGain;
}

double coarse_step(std::span<const double> signal) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < signal.size(); ++i) {
    const double change = std::abs(signal[i] - signal[i - 1]);
    if (change > 0.0) changes.push_back(change);
  }
  // Where white noise is as large as half a step, half of the samples do not change; with more of it the
  // differences show the quantisation as well.
  constexpr double kOftenConstant = 0.1;
  const auto unchanged = static_cast<double>(signal.size() - changes.size());
  if (changes.size() < 20 || unchanged < kOftenConstant * static_cast<double>(signal.size())) return 0.0;
  // Changes of a continuous signal have a density at zero, so that these two quantiles are as 1 to 5; those
  // of a quantised one are equal, but for the digits of the text. The smallest change of all may be that of a
  // repaired sample.
  constexpr double kEqual = 1.1;
  const std::size_t low = changes.size() / 100;
  const std::size_t high = changes.size() / 20;
  const double step = value_at_rank(changes, low);
  return value_at_rank(std::move(changes), high) <= kEqual * step ? step : 0.0;
}

double noise_of_samples(std::span<const double> signal, const std::vector<Interval>& left_out) {
  return std::max(white_noise(signal, left_out), coarse_step(signal) / std::sqrt(12.0));
}

double growth_of_noise_at_half_rate(std::span<const double> signal) {
  const double noise = white_noise(signal);
  // Differences of equal neighbours are rounding.
  if (!(noise > coarse_step(signal) / std::sqrt(12.0))) return 1.0;
  std::vector<double> half;
  half.reserve(signal.size() / 2 + 1);
  for (std::size_t i = 0; i < signal.size(); i += 2) half.push_back(signal[i]);
  return white_noise(half) / noise;
}

}  // namespace slipstack::workbench
