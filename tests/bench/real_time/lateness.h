// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack::bench {

/// How late a process was awake, in bins of 1 us up to 50 ms.
struct Lateness {
  static constexpr std::size_t kBins = 50'000;
  std::array<std::uint32_t, kBins> bins{};
  std::int64_t number = 0;
  double most_s = 0.0;

  void add(double late_s) {
    late_s = std::max(late_s, 0.0);
    most_s = std::max(most_s, late_s);
    ++bins[std::min(static_cast<std::size_t>(late_s * 1e6), kBins - 1)];
    ++number;
  }
  /// What this share of them was at most, s.
  double quantile_s(double share) const {
    const double wanted = share * static_cast<double>(number);
    double sum = 0.0;
    for (std::size_t i = 0; i < kBins; ++i) {
      sum += bins[i];
      if (sum >= wanted) return 1e-6 * static_cast<double>(i + 1);
    }
    return most_s;
  }
};

}  // namespace slipstack::bench
