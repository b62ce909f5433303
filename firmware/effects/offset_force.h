// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

template <class Real>
class OffsetForce {
 public:
  static constexpr EffectText text{
      .id = "offset_force",
      .title = "Constant force",
      .formula = "F = F0",
      .source = "[5]: offset of -3.16 N on EMPS",
      .residual = "a mean that does not depend on place, direction or speed",
      .evidence = "the residual has a mean of {offset} at every place, speed and direction",
      .cause =
          "tilt of the rail, a gravity component, an amplifier or sensor offset | a weight that hangs "
          "on a drum, a spring, an amplifier or sensor offset",
      .confirm =
          "mount the axis the other way round, or level it: gravity changes sign or vanishes, an "
          "offset of an amplifier or sensor stays | take the weight or the spring away: its torque "
          "vanishes, an offset of an amplifier or sensor stays"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"offset", "N", -1.0e6f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 0> shapes{{}};
  static constexpr EffectTraits traits{.role = Role::constant_force, .per_log = true};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 0;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>&, std::span<Real, gain_count> out) { out[0] = Real(1); }
};

}  // namespace slipstack
