// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"
#include "firmware/effects/stribeck.h"

namespace slipstack {

template <class Real>
class FrictionalLag {
 public:
  static constexpr EffectText text{
      .id = "frictional_lag",
      .title = "Frictional lag: friction follows velocity late",
      .formula = "dry friction x (1 + g q), q' = (1/tau + |v|/d) (exp(-(|v|/vs)^n) - q)",
      .source = "frictional memory of the Leuven and GMS models [4]",
      .residual = "against velocity, one branch when speeding up and another when slowing down",
      .evidence =
          "the friction level is higher by {weakening} of itself near standstill, falls over "
          "{stribeck_velocity}, and follows velocity late (time {lag}, distance {lag_distance})",
      .cause = "the lubricant film needs time to form and to collapse",
      .confirm =
          "slow strokes whose speed varies as a sine at several frequencies: the loop force-velocity opens "
          "with frequency"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"weakening", "1", 0.0f, 20.0f, 1, Acts::dry_scale},
  }};
  static constexpr std::array<ShapeSpec, 4> shapes{{
      {"stribeck_velocity", "m/s", 3.0e-4f, 1.0f, ShapeKind::fading_velocity},
      {"exponent", "1", 0.4f, 3.0f, ShapeKind::exponent},
      {"lag", "s", 1.0e-4f, 1.0e3f, ShapeKind::time_constant},
      {"lag_distance", "m", 1.0e-6f, 1.0e2f, ShapeKind::lag_distance},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 4;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    weakening_.prepare(shape.template first<2>(), scales);
    per_tick_ = scales.tick_s / shape[2];
    per_velocity_ = scales.tick_s / shape[3];
  }
  void reset(const Sample<Real>& sample) { weakening_.basis(sample, lagged_); }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    std::array<Real, 1> steady{};
    weakening_.basis(sample, steady);
    follow(steady[0], sample.velocity_mps);
    out[0] = lagged_[0];
  }

  /// The controller reads the steady weakening from a table.
  using Table = typename Stribeck<Real>::Table;
  void prepare_weighted(const std::array<Real, gain_count>& weakening,
                        Table& table) requires std::is_same_v<Real, float> {
    weakening_.prepare_weighted(weakening, table);
  }
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>& weakening,
                const Table& table) requires std::is_same_v<Real, float> {
    follow(table.at(sample.velocity_mps), sample.velocity_mps);
    return weakening[0] * lagged_[0];
  }
  void carry_over(const FrictionalLag& from) { lagged_ = from.lagged_; }

 private:
  void follow(Real steady, Real velocity_mps) {
    const Real rate = approx::multiply_add(per_velocity_, approx::absolute(velocity_mps), per_tick_);
    // Exact for a rate held over the tick, to second order; never beyond the steady value.
    const Real blend = rate / (Real(1) + Real(0.5) * rate);
    lagged_[0] =
        approx::multiply_add(approx::clamp(blend, Real(0), Real(1)), steady - lagged_[0], lagged_[0]);
  }

  Stribeck<Real> weakening_;
  Real per_tick_{};
  Real per_velocity_{};
  std::array<Real, 1> lagged_{};
};

}  // namespace slipstack
