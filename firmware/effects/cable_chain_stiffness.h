// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class CableChainStiffness {
 public:
  static constexpr EffectText text{
      .id = "cable_chain_stiffness",
      .title = "Cable chain stiffness",
      .formula = "F = k (x - x0), as k x + F0 with F0 = -k x0",
      .source = "Hooke",
      .residual = "a straight line against position, the same both ways",
      .evidence =
          "the residual is a straight line against position, the same both ways: {stiffness}, force at "
          "zero {force_at_zero}",
      .cause = "cable chain, hose or bellows pulling towards its rest length",
      .confirm = "creep over the whole stroke both ways with the chain unhooked, then hooked"};
  static constexpr std::array<GainGroup, 2> gains{{
      {"stiffness", "N/m", 0.0f, 1.0e6f, 1, Acts::force},
      {"force_at_zero", "N", -1.0e6f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = sample.position_m;
    out[1] = Real(1);
  }
};

}  // namespace slipstack
