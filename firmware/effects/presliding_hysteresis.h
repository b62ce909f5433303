// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/friction/maxwell_slip.h"

namespace slipstack {

/// Stop operators of the target, and the finer set that the workbench identifies with before reducing it.
inline constexpr int kTargetElements = 10;
inline constexpr int kIdentifiedElements = 32;

/// The hysteresis of rolling guideways as a sum of stop operators with fixed slip distances: linear in the
/// stiffnesses. An element with slip distance 0 is unused and its basis is 0.
template <class Real, int Elements = std::is_same_v<Real, float> ? kTargetElements : kIdentifiedElements>
class PreslidingHysteresis {
 public:
  static constexpr EffectText text{
      .id = "presliding_hysteresis",
      .title = "Pre-sliding hysteresis (Maxwell-slip)",
      .formula = "F = sum_i k_i z_i, z_i stop operators of slip distance D_i",
      .source = "[1] rules I and II, [2], [4]; Maxwell-slip after Iwan",
      .residual = "follows the displacement since the last reversal",
      .evidence = "after each reversal the force climbs over some micrometres before it settles",
      .cause =
          "rolling elements creep before they roll: contact stiffness and micro-slip of balls or rollers",
      .confirm = "slow sines of stepped amplitude, from one to some tens of micrometres, at several places"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"stiffness", "N/m", 0.0f, kUnbounded, Elements, Acts::dry},
  }};
  static constexpr int gain_count = Elements;
  static constexpr int shape_count = Elements;
  static constexpr std::array<ShapeSpec, shape_count> shapes = [] {
    std::array<ShapeSpec, shape_count> specs{};
    for (ShapeSpec& spec : specs) spec = {"slip_distance", "m", 0.0f, 1.0f, ShapeKind::slip_distance};
    return specs;
  }();

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    metres_per_displacement_ = scales.metres_per_displacement;
    std::array<DisplacementOf<Real>, Elements> slip{};
    std::array<Real, Elements> unit{};
    for (std::size_t i = 0; i < Elements; ++i) {
      slip[i] = to_displacement(shape[i]);
      unit[i] = metres_per_displacement_;
    }
    // Slip distances within the bounds of `shapes` are always taken.
    static_cast<void>(elements_.set_elements(slip, unit));
  }
  void reset(const Sample<Real>& sample) { elements_.reset(sample.displacement); }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    elements_.step(sample.displacement);
    for (std::size_t i = 0; i < Elements; ++i) {
      out[i] = static_cast<Real>(elements_.z(i)) * metres_per_displacement_;
    }
  }

 private:
  DisplacementOf<Real> to_displacement(Real slip_m) const {
    const Real scaled = slip_m / metres_per_displacement_;
    if constexpr (std::is_integral_v<DisplacementOf<Real>>) {
      return static_cast<DisplacementOf<Real>>(scaled + Real(0.5));
    } else {
      return scaled;
    }
  }

  MaxwellSlip<static_cast<std::size_t>(Elements), Real, DisplacementOf<Real>> elements_;
  Real metres_per_displacement_{1};
};

}  // namespace slipstack
