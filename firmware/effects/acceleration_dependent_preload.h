// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

template <class Real>
class AccelerationDependentPreload {
 public:
  static constexpr EffectText text{
      .id = "acceleration_dependent_preload",
      .title = "Preload that grows with acceleration",
      .formula = "dry friction x (1 + b f + c f |a| / ak), f = |a| / (1 + |a| / ak)",
      .source =
          "pitching moment of a drive force off the centre of mass; [2]: friction scales with preload; b the "
          "slope at small accelerations, c at large ones, ak between",
      .residual = "follows |acceleration| x direction of friction",
      .evidence =
          "the friction level grows with acceleration, either way: by {pitching} of itself "
          "below {knee}, by {pitching_beyond_knee} above",
      .cause =
          "the motor pulls below the centre of mass: the slide pitches and loads the carriages | gear "
          "teeth, or a bearing of the joint, rub more under load",
      .confirm =
          "repeat one move at doubled acceleration with equal peak speed, then with the mass lower on "
          "the slide: the friction level changes | repeat one move at doubled acceleration with equal "
          "peak speed: the friction level changes"};
  static constexpr std::array<GainGroup, 2> gains{{
      {"pitching", "s2/m", 0.0f, 1.0e3f, 1, Acts::dry_scale},
      {"pitching_beyond_knee", "s2/m", 0.0f, 1.0e3f, 1, Acts::dry_scale},
  }};
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"knee", "m/s2", 1.0e-2f, 1.0e4f, ShapeKind::acceleration},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_knee_s2pm_ = Real(1) / shape[0];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const Real acceleration_mps2 = approx::absolute(sample.acceleration_mps2);
    const Real knees = acceleration_mps2 * inverse_knee_s2pm_;
    out[0] = acceleration_mps2 / (Real(1) + knees);
    out[1] = out[0] * knees;
  }

 private:
  Real inverse_knee_s2pm_{};
};

}  // namespace slipstack
