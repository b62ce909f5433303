// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace slipstack::workbench {

/// Samples of a log: [first, end).
struct Interval {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - first; }
};

/// Number of samples in all intervals together.
inline std::size_t samples_in(const std::vector<Interval>& intervals) {
  std::size_t samples = 0;
  for (const Interval& one : intervals) samples += one.size();
  return samples;
}

}  // namespace slipstack::workbench
