// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/harmonics.h"
#include "firmware/effects/numerics/ripple_table.h"

namespace slipstack {

/// What effects that repeat over a pitch have in common: harmonics of the place within it, cosine and sine of
/// each. What they multiply, their bounds and their texts are the effect's own.
template <class Real>
class Ripple {
 public:
  // From 1 mm: balls of the smallest guides pass every 2 mm, ball screws have a lead of 1 mm at the least,
  // magnets of linear motors lie 6 mm apart and more. What seems to repeat more finely does not repeat along
  // the rail: a log that is coarse for the speed aliases into it.
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"pitch", "m", 1.0e-3f, 1.0f, ShapeKind::pitch},
  }};
  static constexpr int gain_count = 2 * kRippleHarmonics;
  static constexpr bool over_position = true;
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_pitch_per_m_ = Real(1) / shape[0];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    harmonics(approx::sin_cos_of_cycles(sample.position_m * inverse_pitch_per_m_), out);
  }

  /// The controller reads one period of the weighted sum from a table (ripple_table.h).
  void prepare_weighted(const std::array<Real, gain_count>& amplitudes) requires kOnTarget<Real> {
    table_.fill([&](Real cycles) {
      std::array<Real, gain_count> waves;
      harmonics(approx::sin_cos_of_cycles(cycles), std::span<Real, gain_count>(waves));
      Real sum = Real(0);
      for (std::size_t i = 0; i < waves.size(); ++i) sum += amplitudes[i] * waves[i];
      return sum;
    });
  }
  Real weighted(const Sample<Real>& sample,
                const std::array<Real, gain_count>&) const requires kOnTarget<Real> {
    return table_.at(sample.position_m * inverse_pitch_per_m_);
  }

 private:
  Real inverse_pitch_per_m_{};
  [[no_unique_address]] typename TableFor<RippleTable, Real>::type table_;
};

}  // namespace slipstack
