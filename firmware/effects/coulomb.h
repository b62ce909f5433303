// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

template <class Real>
class Coulomb {
 public:
  static constexpr EffectText text{
      .id = "coulomb",
      .title = "Coulomb friction",
      .formula = "F = Fc sat(v / vs)",
      .source = "Coulomb; saturated so that it is defined at standstill",
      .residual = "steps by twice its level when the velocity changes sign",
      .evidence = "the residual steps by twice {coulomb} when the velocity changes sign",
      .cause = "dry friction, in a log too coarse to show pre-sliding",
      .confirm = "slow moves at constant velocity both ways: half the difference of the mean forces"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"coulomb", "N", 0.0f, 1.0e6f, 1, Acts::dry},
  }};
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"saturation_velocity", "m/s", 1.0e-7f, 0.01f, ShapeKind::velocity},
  }};
  /// Beside hysteresis: a virgin curve with a steep start reaches a tenth of its level within one encoder
  /// step (a stretched exponential of exponent 0.6 does within a hundredth of its travel).
  static constexpr EffectTraits traits{.role = Role::saturating_friction,
                                       .plausible = {.least_share_of_dry = 0.10}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_velocity_spm_ = Real(1) / shape[0];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = approx::clamp(sample.velocity_mps * inverse_velocity_spm_, Real(-1), Real(1));
  }

 private:
  Real inverse_velocity_spm_{};
};

}  // namespace slipstack
