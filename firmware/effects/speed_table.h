// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "firmware/effects/approx.h"
#include "firmware/friction/packed_arithmetic.h"

namespace slipstack {

/// A velocity weakening, a mixture of exp(-u) and 1 / (1 + u), u = (|v| / vs)^n, 0.4 <= n <= 3, read from a
/// table: 12 instructions on the controller instead of some 150 for two exponentials and a logarithm.
///
/// The bits of a positive float rise with its value, and the upper ones are nearly its logarithm: intervals
/// are even within each octave, 2, 4 or 8 of them as n asks, with a parabola in each. Largest error
/// 4.8e-4 for n < 0.8, 3.1e-4 above (tests/unit/control/table_test.cpp).
class SpeedTable {
 public:
  /// Fills the table from `weakening`, a function of |v| in m/s. About 60 000 instructions: not for the tick.
  template <class Weakening>
  void fill(float stribeck_velocity_mps, float exponent, Weakening weakening) {
    const std::uint32_t halvings = exponent < 0.8F ? 1U : (exponent < 1.6F ? 2U : 3U);
    shift_ = 23U - halvings;
    // u runs from 2^-13.6 to at least 2^12: within 2.5e-4 of the weakening's two ends.
    const float first = stribeck_velocity_mps * approx::exp2(-13.6F / exponent);
    first_bits_ = std::bit_cast<std::uint32_t>(first) & ~((1U << shift_) - 1U);
    const std::uint32_t last = first_bits_ + (kIntervals << shift_) - 1U;
    beyond_ = ~last & 0xFFFF0000U;
    before_ = beyond_ + first_bits_;
    shift_up_ = 32U - shift_;
    const auto at_step = [&](std::uint32_t halves) {
      return weakening(std::bit_cast<float>(first_bits_ + (halves << (shift_ - 1U))));
    };
    for (std::uint32_t i = 0; i < kIntervals; ++i) {
      const float begin = at_step(2 * i);
      const float middle = at_step(2 * i + 1);
      const float end = at_step(2 * i + 2);
      intervals_[i] = {begin, 4.0F * middle - 3.0F * begin - end, 2.0F * (begin + end) - 4.0F * middle};
    }
  }

  /// The weakening at a velocity of either sign, m/s. NaN reads the last interval.
  float at(float velocity_mps) const {
    const auto bits = std::bit_cast<std::uint32_t>(approx::absolute(velocity_mps));
    // Limited to [0, the last place] by the upper half of the word: the lower half of first_bits_ is zero,
    // and moves what is read at either end, where the weakening is flat, by a part of one interval.
    const std::uint32_t place = subtract_saturating_unsigned(add_saturating_unsigned(bits, beyond_), before_);
    // What is below the interval, at the upper end of the word; exact, since it has fewer than 24 bits.
    const float t = approx::from_fixed<32>(place << shift_up_);
    const Parabola* const p = approx::one_address(&intervals_[place >> shift_]);
    return approx::multiply_add(approx::multiply_add(p->bend, t, p->slope), t, p->begin);
  }

 private:
  static constexpr std::uint32_t kIntervals = 128;
  struct Parabola {
    float begin, slope, bend;
  };

  std::uint32_t first_bits_ = 0;
  std::uint32_t beyond_ = 0xFFFF0000U;  ///< what the last place lacks of a full upper half
  std::uint32_t before_ = 0xFFFF0000U;
  std::uint32_t shift_ = 22;
  std::uint32_t shift_up_ = 10;
  std::array<Parabola, kIntervals> intervals_{};
};

}  // namespace slipstack
