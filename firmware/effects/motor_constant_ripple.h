// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"
#include "firmware/effects/harmonics.h"
#include "firmware/effects/ripple_table.h"

namespace slipstack {

template <class Real>
class MotorConstantRipple {
 public:
  static constexpr EffectText text{
      .id = "motor_constant_ripple",
      .title = "Motor constant that varies with position",
      .formula = "F x (1 + sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p)), h = 1..4",
      .source = "back-EMF harmonics of a linear motor; current x nominal constant misstates the force",
      .residual =
          "repeats with position and grows with the force: nothing at coasting, most while accelerating",
      .evidence =
          "the residual repeats every {pitch} of position and grows with the force, amplitude "
          "{cosine_and_sine} of it",
      .cause = "back-EMF that is not a sine, commutation offset, a weak magnet",
      .confirm = "the same move with double the payload: the ripple doubles with the force"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"cosine_and_sine", "1", -0.9f, 0.9f, 2 * kRippleHarmonics, Acts::total_scale},
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
