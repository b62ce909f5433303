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
      .formula = "dry friction x (1 + g q), tau q' + q = exp(-(|v|/vs)^n)",
      .source = "frictional memory of the Leuven and GMS models [4]",
      .residual = "against velocity, one branch when speeding up and another when slowing down",
      .evidence =
          "the friction level is higher by {weakening} of itself near standstill, falls over "
          "{stribeck_velocity}, and follows velocity {lag} late",
      .cause = "the lubricant film needs time to form and to collapse",
      .confirm =
          "slow strokes whose speed varies as a sine at several frequencies: the loop force-velocity opens "
          "with frequency"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"weakening", "1", 0.0f, 20.0f, 1, Acts::dry_scale},
  }};
  static constexpr std::array<ShapeSpec, 3> shapes{{
      {"stribeck_velocity", "m/s", 1.0e-5f, 1.0f, ShapeKind::velocity},
      {"exponent", "1", 0.4f, 3.0f, ShapeKind::exponent},
      {"lag", "s", 1.0e-4f, 2.0f, ShapeKind::time_constant},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 3;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    weakening_.prepare(shape.template first<2>(), scales);
    blend_ = Real(1) - approx::exp(-scales.tick_s / shape[2]);
  }
  void reset(const Sample<Real>& sample) { weakening_.basis(sample, lagged_); }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    std::array<Real, 1> steady{};
    weakening_.basis(sample, steady);
    lagged_[0] += blend_ * (steady[0] - lagged_[0]);
    out[0] = lagged_[0];
  }

 private:
  Stribeck<Real> weakening_;
  Real blend_{};
  std::array<Real, 1> lagged_{};
};

}  // namespace slipstack
