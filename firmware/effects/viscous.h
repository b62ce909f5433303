// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class Viscous {
 public:
  static constexpr EffectText text{
      .id = "viscous",
      .title = "Viscous friction",
      .formula = "F = c v",
      .source = "[5] and any text on lubrication",
      .residual = "a straight line through zero against velocity",
      .evidence = "the residual is a straight line against velocity: {viscous}",
      .cause = "grease, seals, back-EMF of the current loop",
      .confirm = "long moves at four or more constant speeds: the mean force rises in proportion"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"viscous", "N s/m", 0.0f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr EffectTraits traits{.role = Role::viscous_friction};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) { out[0] = sample.velocity_mps; }
};

}  // namespace slipstack
