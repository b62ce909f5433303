// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class Inertia {
 public:
  static constexpr EffectText text{
      .id = "inertia",
      .title = "Inertia of the moving mass",
      .formula = "F = m a",
      .source = "Newton; [1] equation of motion",
      .residual = "proportional to acceleration, the same at every place and speed",
      .evidence = "the residual is proportional to acceleration: {mass} are moved",
      .cause = "the moving mass itself",
      .confirm =
          "weigh the slide, or accelerate it at several levels far from reversals | take it from the "
          "drawing of the rotor and its load, or accelerate at several levels far from reversals"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"mass", "kg", 0.0f, 1.0e5f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr EffectTraits traits{
      .role = Role::inertia, .in_default_baseline = true, .per_log = true, .plannable = false};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = sample.acceleration_mps2;
  }
};

}  // namespace slipstack
