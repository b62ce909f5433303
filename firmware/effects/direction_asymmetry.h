// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

template <class Real>
class DirectionAsymmetry {
 public:
  static constexpr EffectText text{
      .id = "direction_asymmetry",
      .title = "Friction that differs between the directions",
      .formula =
          "dry friction x (1 + b d + e s) + c |v|, d = +1 or -1 with the sign of the dry friction, "
          "s = (3 u - u^3) / 2, u = sat(v/vs)",
      .source = "[5]: fatigue of the screw; b follows the hysteresis through a reversal, e the motion",
      .residual = "another level and another slope against velocity for each direction",
      .evidence =
          "the friction level differs by {level_asymmetry} to either side between the directions, by "
          "{level_asymmetry_by_motion} more once the axis moves, the viscous slope by {viscous_asymmetry}",
      .cause =
          "wear or tilt of the carriages, a screw or belt fatigued on one side, wiper lips | flanks "
          "of a gear worn on one side, a seal whose lip drags one way",
      .confirm =
          "equal slow and fast moves both ways: compare the two levels and slopes; mount the "
          "carriage the other way round and repeat | equal slow and fast turns both ways: compare the "
          "two levels and slopes; mount the gear the other way round and repeat"};
  static constexpr std::array<GainGroup, 3> gains{{
      {"level_asymmetry", "1", -0.95f, 0.95f, 1, Acts::dry_scale},
      {"level_asymmetry_by_motion", "1", -0.95f, 0.95f, 1, Acts::dry_scale},
      {"viscous_asymmetry", "N s/m", -1.0e6f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"saturation_velocity", "m/s", 1.0e-6f, 1.0e-2f, ShapeKind::velocity},
  }};
  /// Viscous friction opposes motion in either direction: without a share of c v that is at least as large,
  /// c |v| would drive one of them.
  static constexpr EffectTraits traits{.role = Role::directional_friction,
                                       .part_of_another = {.gain = 2, .whole = Role::viscous_friction}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_velocity_spm_ = Real(1) / shape[0];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = approx::select(sample.dry_friction_N < Real(0), Real(-1), Real(1));
    const Real u = approx::clamp(sample.velocity_mps * inverse_velocity_spm_, Real(-1), Real(1));
    out[1] = u * (Real(1.5) - Real(0.5) * u * u);
    out[2] = approx::absolute(sample.velocity_mps);
  }

 private:
  Real inverse_velocity_spm_{};
};

}  // namespace slipstack
