// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/reduction.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slipstack::workbench {

Reduction reduction(const std::vector<double>& before, const std::vector<double>& after) {
  const double before_sum = std::accumulate(before.begin(), before.end(), 1e-300);
  const double after_sum = std::accumulate(after.begin(), after.end(), 0.0);
  Reduction result{1.0 - std::sqrt(std::max(0.0, after_sum) / before_sum), 0.0};
  const auto blocks = static_cast<double>(before.size());
  std::vector<double> left_out;
  for (std::size_t b = 0; b < before.size(); ++b) {
    const double rest = std::max(before_sum - before[b], 1e-300);
    left_out.push_back(1.0 - std::sqrt(std::max(0.0, after_sum - after[b]) / rest));
  }
  const double mean = std::accumulate(left_out.begin(), left_out.end(), 0.0) / blocks;
  double variance = 0.0;
  for (const double value : left_out) variance += (value - mean) * (value - mean);
  result.standard_error = std::sqrt(variance * (blocks - 1.0) / blocks);
  return result;
}

double reduction_beyond(double energy, double expected) {
  const double excess = std::clamp((energy - expected) / (1.0 - expected), 0.0, 1.0);
  return 1.0 - std::sqrt(1.0 - excess);
}

/// The share of the blocks that may be left out of the test.
constexpr double kStrongBlocks = 0.2;

bool lowered_significantly(const std::vector<double>& before, const std::vector<double>& after,
                           double significance) {
  if (reduction(before, after).value < kLeastReduction) return false;
  std::vector<std::size_t> weakest_first(before.size());
  std::iota(weakest_first.begin(), weakest_first.end(), std::size_t{0});
  std::sort(weakest_first.begin(), weakest_first.end(),
            [&](std::size_t a, std::size_t b) { return before[a] - after[a] < before[b] - after[b]; });
  std::vector<double> rest_before;
  std::vector<double> rest_after;
  for (const std::size_t b : weakest_first) {
    rest_before.push_back(before[b]);
    rest_after.push_back(after[b]);
  }
  const auto fewest = static_cast<std::size_t>((1.0 - kStrongBlocks) * static_cast<double>(before.size()));
  while (!rest_before.empty() && rest_before.size() >= fewest) {
    if (reduction(rest_before, rest_after).is_significant(significance)) return true;
    rest_before.pop_back();
    rest_after.pop_back();
  }
  return false;
}

}  // namespace slipstack::workbench
