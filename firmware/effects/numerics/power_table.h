// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// x^p for x >= 0 and 0.5 <= p <= 1.5, from two tables: with x = 2^octave m, 1 <= m < 2, it is
/// (2^octave)^p m^p, and m^p is a parabola in each eighth of the octave. Relative error 6.5e-6
/// (tests/unit/control/table_test.cpp), none for p = 1 but that of rounding. A power by its logarithm takes
/// three times the work.
class PowerTable {
 public:
  static constexpr std::uint32_t kOctaves = 32;
  static constexpr std::uint32_t kIntervals = 8;
  /// begin + (slope + bend t) t, t = 0 .. 1 over the interval.
  struct Parabola {
    float begin, slope, bend;
  };

  /// Not for the tick.
  void fill(float p) {
    float octave = kFirst;
    for (float& factor : octaves_) {
      factor = approx::exp2(p * octave);
      octave += 1.0F;
    }
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      const auto at = [&](std::size_t halves) {
        return approx::power(1.0F + static_cast<float>(2 * i + halves) / (2 * kIntervals), p);
      };
      const float begin = at(0);
      const float middle = at(1);
      const float end = at(2);
      intervals_[i] = {begin, 4.0F * middle - 3.0F * begin - end, 2.0F * (begin + end) - 4.0F * middle};
    }
  }

  /// Below 2^-24 the value there, from 2^8 on, and for NaN, the one before.
  float at(float x) const {
    constexpr std::uint32_t kLowest = std::bit_cast<std::uint32_t>(0x1p-24F);
    constexpr std::uint32_t kHighest = kLowest + (kOctaves << kMantissaBits) - 1U;
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const std::uint32_t above = bits > kLowest ? bits : kLowest;
    const std::uint32_t place = (above < kHighest ? above : kHighest) - kLowest;
    constexpr std::uint32_t kBelow = kMantissaBits - 3U;  // bits below the eighth
    const float t = static_cast<float>(place & ((1U << kBelow) - 1U)) * (1.0F / (1U << kBelow));
    const Parabola& p = intervals_[place >> kBelow & (kIntervals - 1U)];
    return (p.begin + (p.slope + p.bend * t) * t) * octaves_[place >> kMantissaBits];
  }

  const std::array<float, kOctaves>& octaves() const { return octaves_; }
  const std::array<Parabola, kIntervals>& intervals() const { return intervals_; }

 private:
  static constexpr std::uint32_t kMantissaBits = 23;
  static constexpr float kFirst = -24.0F;

  std::array<float, kOctaves> octaves_{};
  std::array<Parabola, kIntervals> intervals_{};
};

}  // namespace slipstack
