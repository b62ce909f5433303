// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/noise_estimate.h"

#include <cmath>
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

}  // namespace slipstack::workbench
