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

/// Smallest and largest of some values.
struct ValueRange {
  double low = 0.0;
  double high = 0.0;
  double length() const { return high - low; }
};

/// `values` must not be empty. O(n).
inline ValueRange value_range(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

/// Root of the mean square; `values` must not be empty. O(n).
inline double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// The value at position `rank`, counted from 0, of the sorted values; rank < values.size(). O(n).
inline double value_at_rank(std::vector<double> values, std::size_t rank) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The value that this share of the values (0 to 1) does not exceed: that of rank share * (n - 1), rounded
/// down; zero for no values. O(n).
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  return value_at_rank(std::move(values), rank);
}

/// The median; of an even number of values the upper one of the middle two. `values` must not be empty. O(n).
inline double median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return value_at_rank(std::move(values), middle);
}

/// The median of the magnitude of a normal variable in standard deviations: the 0.75 quantile of the standard
/// normal distribution. A median of magnitudes divided by it is a robust standard deviation.
inline constexpr double kMedianOfNormal = 0.67448975;

}  // namespace slipstack::workbench
