// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class PayloadMass {
 public:
  static constexpr EffectText text{
      .id = "payload_mass",
      .title = "Payload mass beyond the nominal mass",
      .formula = "F = dm a",
      .source = "Newton; [1] set-up 2, 0.845 kg added",
      .residual = "proportional to acceleration",
      .evidence = "the residual is proportional to acceleration: {payload_mass} beyond what the log declares",
      .cause =
          "a gripper, a part or a cable that the nominal mass or inertia leaves out, or a "
          "wrong data sheet",
      .confirm =
          "repeat one fast move with a known mass or inertia added: the fitted one must rise by as much"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"payload_mass", "kg", -1.0e5f, 1.0e5f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr EffectTraits traits{
      .role = Role::added_mass, .per_log = true, .plausible = {.least_share_of_force = kRecorderErrs}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = sample.acceleration_mps2;
  }
};

}  // namespace slipstack
