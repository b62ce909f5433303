// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/power_table.h"

namespace slipstack {

template <class Real>
class QuadraticDrag {
 public:
  static constexpr EffectText text{
      .id = "quadratic_drag",
      .title = "Quadratic drag",
      .formula = "F = c2 v |v| (|v| / v1)^(n - 2), v1 = 1 m/s",
      .source =
          "fluid drag: n = 2 where the flow is turbulent, 1.5 to 1.8 in laminar boundary layers and smooth "
          "gaps; eddy currents at low slip are viscous instead",
      .residual = "grows with the square of velocity, or nearly, opposing motion",
      .evidence =
          "the residual grows with the square of velocity, or nearly (exponent {exponent}): "
          "{quadratic_drag}",
      .cause =
          "air displaced in a closed guide, bellows, churning grease | air that a fan or rotor stirs, "
          "churning grease",
      .confirm =
          "moves at doubled speeds: the added force quadruples; open the bellows and repeat | "
          "turns at doubled speeds: the added torque quadruples"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"quadratic_drag", "N s2/m2", 0.0f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 1> shapes{{
      {"exponent", "1", 1.5f, 2.5f, ShapeKind::nominal_exponent},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 1;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    above_one_ = shape[0] - Real(1);
    if constexpr (kOnTarget<Real>) table_.fill(above_one_);
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    out[0] = sample.velocity_mps * growth(approx::absolute(sample.velocity_mps));
  }
  /// The controller reads the power from a table (power_table.h).
  Real weighted(const Sample<Real>& sample,
                const std::array<Real, gain_count>& drag) const requires kOnTarget<Real> {
    return drag[0] * (sample.velocity_mps * table_.at(approx::absolute(sample.velocity_mps)));
  }

 private:
  // The square is exact without the power.
  Real growth(Real speed_mps) const {
    return above_one_ == Real(1) ? speed_mps : approx::power(speed_mps, above_one_);
  }

  Real above_one_{1};
  [[no_unique_address]] typename TableFor<PowerTable, Real>::type table_;
};

}  // namespace slipstack
