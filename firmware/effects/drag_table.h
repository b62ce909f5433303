// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "firmware/effects/approx.h"

namespace slipstack {

/// A function of |v| that grows as a power between 0.5 and 1.5, read from a table: nine instructions on the
/// controller. Four chords in each octave from 1 mm/s to 64 m/s, the first and the last go on beyond; largest
/// error 0.6 % of the value within, none for the power 1 (tests/unit/control/table_test.cpp).
class DragTable {
 public:
  /// Fills the table from `growth`, a function of |v| in m/s: not for the tick.
  template <class Growth>
  void fill(Growth growth) {
    for (std::uint32_t i = 0; i < kChords; ++i) {
      const float begin = std::bit_cast<float>(kFirstBits + (i << kShift));
      const float end = std::bit_cast<float>(kFirstBits + ((i + 1) << kShift));
      const float at_begin = growth(begin);
      const float slope = (growth(end) - at_begin) / (end - begin);
      chords_[i] = {at_begin - slope * begin, slope};
    }
  }

  /// The function at a speed, m/s, not negative.
  float at(float speed_mps) const {
    const auto above = static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(speed_mps) - kFirstBits);
    const Chord* const chord = approx::one_address(&chords_[approx::saturated_shifted<kShift, 6>(above)]);
    return approx::multiply_add(chord->slope, speed_mps, chord->at_zero);
  }

 private:
  static constexpr std::uint32_t kChords = 64;
  static constexpr std::uint32_t kShift = 21;              ///< a quarter of an octave
  static constexpr std::uint32_t kFirstBits = 0x3A800000;  ///< 2^-10
  struct Chord {
    float at_zero, slope;
  };

  std::array<Chord, kChords> chords_{};
};

}  // namespace slipstack
