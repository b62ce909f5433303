// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// The two velocity weakenings exp(-u) and 1 / (1 + u), u = (|v| / vs)^n, 0.4 <= n <= 3, read from a table.
///
/// The bits of a positive float rise with its value, and the upper ones are nearly its logarithm: intervals
/// are even within each octave, 2, 4 or 8 of them as n asks, with a parabola in each. Largest error
/// 4.8e-4 for n < 0.8, 3.1e-4 above (tests/unit/control/table_test.cpp).
class SpeedTable {
 public:
  using Values = std::array<float, 2>;
  static constexpr std::uint32_t kIntervals = 128;
  struct Knot {
    float value;
    float bend;  ///< of the interval that begins here
  };

  /// Fills the table from `weakening`, a function of |v| in m/s that returns Values. Not for the tick.
  template <class Weakening>
  void fill(float stribeck_velocity_mps, float exponent, Weakening weakening) {
    const std::uint32_t halvings = exponent < 0.8F ? 1U : (exponent < 1.6F ? 2U : 3U);
    shift_ = 23U - halvings;
    last_ = (kIntervals << shift_) - 1U;
    mask_ = (1U << shift_) - 1U;
    per_interval_ = 1.0F / static_cast<float>(1U << shift_);
    // u runs from 2^-13.6 to at least 2^12: within 2.5e-4 of the weakenings' two ends.
    const float first = stribeck_velocity_mps * approx::exp2(-13.6F / exponent);
    first_bits_ = std::bit_cast<std::uint32_t>(first) & ~mask_;
    const auto at_step = [&](std::uint32_t halves) {
      return weakening(std::bit_cast<float>(first_bits_ + (halves << (shift_ - 1U))));
    };
    for (std::uint32_t i = 0; i <= kIntervals; ++i) {
      const Values begin = at_step(2 * i);
      const Values middle = at_step(2 * i + 1);
      const Values end = at_step(2 * i + 2);
      for (std::size_t k = 0; k < begin.size(); ++k) {
        knots_[i][k] = {begin[k], 2.0F * (begin[k] + end[k]) - 4.0F * middle[k]};
      }
    }
  }

  /// Both at a velocity of either sign, m/s; before the first interval its begin, beyond the last one its
  /// end, which NaN reads as well.
  Values at(float velocity_mps) const {
    const auto bits = std::bit_cast<std::uint32_t>(approx::absolute(velocity_mps));
    const std::uint32_t above = bits > first_bits_ ? bits - first_bits_ : 0U;
    const std::uint32_t place = above < last_ ? above : last_;
    const float t = static_cast<float>(place & mask_) * per_interval_;
    const auto& begin = knots_[place >> shift_];
    const auto& end = knots_[(place >> shift_) + 1U];
    return {parabola(begin[0], end[0], t), parabola(begin[1], end[1], t)};
  }

  /// The begin of the first interval and the length of each, in bits of a float, and the knots of both.
  std::uint32_t first_bits() const { return first_bits_; }
  std::uint32_t shift() const { return shift_; }
  const std::array<std::array<Knot, 2>, kIntervals + 1>& knots() const { return knots_; }

 private:
  static float parabola(const Knot& begin, const Knot& end, float t) {
    const float slope = end.value - begin.value - begin.bend;
    return begin.value + (slope + begin.bend * t) * t;
  }

  std::uint32_t first_bits_ = 0;
  std::uint32_t shift_ = 22;
  std::uint32_t last_ = 0;     // of the table, in bits
  std::uint32_t mask_ = 0;     // the bits within an interval
  float per_interval_ = 0.0F;  // 2^-shift
  std::array<std::array<Knot, 2>, kIntervals + 1> knots_{};
};

}  // namespace slipstack
