// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// One period of a sum of harmonics, read from a table with a parabola in each of 64 intervals. Largest error
/// 5e-4 of the amplitude of the fourth harmonic, 2e-4 of the third, 6e-5 of the second, 8e-6 of the first
/// (tests/unit/control/table_test.cpp).
class RippleTable {
 public:
  static constexpr std::uint32_t kIntervals = 64;
  /// begin + (slope + bend t) t, t = 0 .. 1 over the interval.
  struct Parabola {
    float begin, slope, bend;
  };

  /// Fills the table from `wave`, a function of the place in periods on [0, 1]. Not for the
  /// tick.
  template <class Wave>
  void fill(Wave wave) {
    const auto at_step = [&](std::uint32_t halves) {
      return wave(static_cast<float>(halves) * (0.5F / static_cast<float>(kIntervals)));
    };
    for (std::uint32_t i = 0; i < kIntervals; ++i) {
      const float begin = at_step(2 * i);
      const float middle = at_step(2 * i + 1);
      const float end = at_step(2 * i + 2);
      intervals_[i] = {begin, 4.0F * middle - 3.0F * begin - end, 2.0F * (begin + end) - 4.0F * middle};
    }
  }

  /// The wave at a place in periods, |cycles| < 2^31.
  float at(float cycles) const {
    const float period = cycles - static_cast<float>(approx::floor_to_int(cycles));
    const float place = period * static_cast<float>(kIntervals);
    const auto whole = static_cast<std::int32_t>(place);
    const float t = place - static_cast<float>(whole);
    // The period of a small negative place rounds to 1, the begin of the next one.
    const Parabola& p = intervals_[static_cast<std::uint32_t>(whole) % kIntervals];
    return p.begin + (p.slope + p.bend * t) * t;
  }

  const std::array<Parabola, kIntervals>& intervals() const { return intervals_; }

 private:
  std::array<Parabola, kIntervals> intervals_{};
};

}  // namespace slipstack
