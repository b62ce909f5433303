// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/approx.h"
#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class QuadraticDrag {
 public:
  static constexpr EffectText text{
      .id = "quadratic_drag",
      .title = "Quadratic drag",
      .formula = "F = c2 v |v|",
      .source = "fluid drag; eddy currents at low slip are viscous instead",
      .residual = "grows with the square of velocity, opposing motion",
      .evidence = "the residual grows with the square of velocity: {quadratic_drag}",
      .cause = "air displaced in a closed guide, bellows, churning grease",
      .confirm = "strokes at doubled speeds: the added force quadruples; open the bellows and repeat"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"quadratic_drag", "N s2/m2", 0.0f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = sample.velocity_mps * approx::absolute(sample.velocity_mps);
  }
};

}  // namespace slipstack
