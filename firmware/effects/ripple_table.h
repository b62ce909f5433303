// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/effects/approx.h"

namespace slipstack {

/// One period of a sum of harmonics, read from a table with a parabola in each of 64 intervals: 25
/// instructions on the controller instead of some 100. Largest error 5e-4 of the amplitude of the fourth
/// harmonic, 2e-4 of the third, 6e-5 of the second, 8e-6 of the first
/// (tests/unit/control/table_test.cpp).
class RippleTable {
 public:
  /// Fills the table from `wave`, a function of the place in periods on [0, 1]. 13 000 instructions: not for
  /// the tick.
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

  /// The wave at a place in periods, |cycles| < 2^31; the same work for every place.
  float at(float cycles) const {
    const float part = cycles - static_cast<float>(static_cast<std::int32_t>(cycles));
    // Masking makes the remainder of a negative place positive.
    const auto place = static_cast<std::uint32_t>(static_cast<std::int32_t>(part * kSteps));
    const Parabola* const p = approx::one_address(&intervals_[(place >> kRestBits) % kIntervals]);
    const float t = approx::from_fixed<kRestBits>(place & ((1U << kRestBits) - 1U));
    return approx::multiply_add(approx::multiply_add(p->bend, t, p->slope), t, p->begin);
  }

 private:
  static constexpr std::uint32_t kIntervals = 64;
  static constexpr int kRestBits = 18;
  static constexpr float kSteps = static_cast<float>(kIntervals << kRestBits);
  struct Parabola {
    float begin, slope, bend;
  };

  std::array<Parabola, kIntervals> intervals_{};
};

}  // namespace slipstack
