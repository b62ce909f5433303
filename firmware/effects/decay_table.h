// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/effects/approx.h"

namespace slipstack {

/// 1 - exp(-x) for x >= 0, read from a table with a parabola in each of 128 intervals of 1/8; constant from
/// 16 on. Largest error 1.7e-5 (tests/unit/control/table_test.cpp). About 20 instructions.
class DecayTable {
 public:
  /// Fills the table: some 20 000 instructions, of the compiler (kDecayTable).
  constexpr DecayTable() {
    const auto at_step = [](std::uint32_t halves) {
      return -approx::exp_minus_one(static_cast<float>(halves) * (-0.5F / kPerUnit));
    };
    for (std::uint32_t i = 0; i < kIntervals; ++i) {
      const float begin = at_step(2 * i);
      const float middle = at_step(2 * i + 1);
      const float end = at_step(2 * i + 2);
      intervals_[i] = {begin, 4.0F * middle - 3.0F * begin - end, 2.0F * (begin + end) - 4.0F * middle};
    }
  }

  /// `scaled` is x times kPerUnit, not negative; NaN reads the first interval.
  float at(float scaled) const {
    constexpr float kLast = static_cast<float>(kIntervals) - 0x1p-16F;
    const float place = scaled < kLast ? scaled : kLast;
    const auto index = static_cast<std::int32_t>(place);
    const float t = place - static_cast<float>(index);
    const Parabola* const p =
        approx::one_address(&intervals_[static_cast<std::uint32_t>(index) % kIntervals]);
    return approx::multiply_add(approx::multiply_add(p->bend, t, p->slope), t, p->begin);
  }

  static constexpr float kPerUnit = 8.0F;

 private:
  static constexpr std::uint32_t kIntervals = 128;
  struct Parabola {
    float begin, slope, bend;
  };
  std::array<Parabola, kIntervals> intervals_{};
};

/// The only one: it depends on nothing, and lies with the code.
inline constexpr DecayTable kDecayTable;

}  // namespace slipstack
