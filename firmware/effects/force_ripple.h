// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"
#include "firmware/effects/harmonics.h"
#include "firmware/effects/ripple_table.h"

namespace slipstack {

template <class Real>
class ForceRipple {
 public:
  static constexpr EffectText text{
      .id = "force_ripple",
      .title = "Force ripple (cogging)",
      .formula = "F = sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p), h = 1..4",
      .source = "detent force of a permanent-magnet linear motor, periodic in the magnet pitch",
      .residual = "repeats with position, the same in both directions and at every force",
      .evidence =
          "the residual repeats every {pitch} of position, the same in both directions, amplitude "
          "{cosine_and_sine}",
      .cause = "magnets attracting the iron of the forcer (cogging); a ball-pass pattern of the carriage",
      .confirm =
          "creep over several magnet pitches both ways with the motor off, pushed by hand or by a spring"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"cosine_and_sine", "N", -1.0e6f, 1.0e6f, 2 * kRippleHarmonics, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"pitch", "m", 1.0e-4f, 1.0f, ShapeKind::pitch},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_pitch_per_m_ = Real(1) / shape[0];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    harmonics(approx::sin_cos_of_cycles(sample.position_m * inverse_pitch_per_m_), out);
  }

  /// The controller reads one period of the weighted sum from a table (ripple_table.h).
  using Table = std::conditional_t<std::is_same_v<Real, float>, RippleTable, NoTable>;
  void prepare_weighted(const std::array<Real, gain_count>& amplitudes,
                        Table& table) const requires std::is_same_v<Real, float> {
    table.fill([&](Real cycles) { return harmonic_sum(approx::sin_cos_of_cycles(cycles), amplitudes); });
  }
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>&,
                const Table& table) const requires std::is_same_v<Real, float> {
    return table.at(sample.position_m * inverse_pitch_per_m_);
  }

 private:
  Real inverse_pitch_per_m_{};
};

}  // namespace slipstack
