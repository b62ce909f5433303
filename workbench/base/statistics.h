// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace slipstack::workbench {

inline double squared(double x) {
  return x * x;
}

/// Root of the mean square; `values` must not be empty. O(n).
inline double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// The value at `rank`, from 0, of the sorted values; there must be so many. O(n).
inline double value_at_rank(std::vector<double> values, std::size_t rank) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The median, of an even number the upper one; `values` must not be empty. O(n).
inline double median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return value_at_rank(std::move(values), middle);
}

/// The median of the magnitudes of a normal variable, in standard deviations.
inline constexpr double kMedianOfNormal = 0.67448975;

}  // namespace slipstack::workbench
