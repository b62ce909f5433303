// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/speed_table.h"

namespace slipstack {

template <class Real>
class Stribeck {
 public:
  static constexpr EffectText text{
      .id = "stribeck",
      .title = "Stribeck effect: friction falls with velocity",
      .formula = "dry friction x (1 + g exp(-u) + h / (1 + u)), u = (|v|/vs)^n",
      .source =
          "Stribeck; g after Bo and Pavelescu (Wear 82, 1982), h after Hess and Soom (J. Tribology 112, "
          "1990); "
          "s(v) of the Leuven and GMS models [4]",
      .residual = "largest at low velocity, opposing motion, vanishing beyond a low velocity",
      .evidence =
          "the friction falls from standstill to its level at speed over {stribeck_velocity}, by "
          "{weakening_at_standstill} of that level, {weakening_with_tail} of the level with a long tail",
      .cause =
          "a lubricant film that forms with speed: wipers, seals; slight in rolling guideways | a "
          "lubricant film that forms with speed: seals, gear teeth; slight in rolling bearings",
      .confirm =
          "moves at constant velocity, from very slow to fast: friction level against the logarithm of "
          "velocity"};
  /// A breakaway of more than four times the level at speed is chosen as the limit: what lies beyond
  /// compensates another effect.
  static constexpr std::array<GainGroup, 2> gains{{
      {"weakening", "1", 0.0f, 3.0f, 1, Acts::dry_scale},
      {"weakening_with_tail", "1", 0.0f, 3.0f, 1, Acts::dry_scale},
  }};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"stribeck_velocity", "m/s", 3.0e-4f, 1.0f, ShapeKind::fading_velocity},
      {"exponent", "1", 0.4f, 3.0f, ShapeKind::exponent},
  }};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    inverse_velocity_spm_ = Real(1) / shape[0];
    exponent_ = shape[1];
    if constexpr (kOnTarget<Real>) {
      table_.fill(shape[0], exponent_, [this](Real speed_mps) {
        std::array<Real, gain_count> out{};
        basis({.velocity_mps = speed_mps}, out);
        return out;
      });
    }
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const std::array<Real, gain_count> now = steady(sample.velocity_mps);
    for (std::size_t i = 0; i < gain_count; ++i) out[i] = now[i];
  }
  /// The basis at a velocity: it depends on nothing else.
  std::array<Real, gain_count> steady(Real velocity_mps) const {
    const Real speed_ratio = approx::absolute(velocity_mps) * inverse_velocity_spm_;
    const Real u = approx::power(speed_ratio, exponent_);
    return {approx::exp(-u), Real(1) / (Real(1) + u)};
  }

  /// The controller reads the basis from a table (speed_table.h): a power, an exponential and a division take
  /// ten times the work.
  std::array<Real, gain_count> tabulated(Real velocity_mps) const requires kOnTarget<Real> {
    return table_.at(velocity_mps);
  }
  Real weighted(const Sample<Real>& sample,
                const std::array<Real, gain_count>& weakening) const requires kOnTarget<Real> {
    const auto basis = tabulated(sample.velocity_mps);
    return weakening[0] * basis[0] + weakening[1] * basis[1];
  }

 private:
  Real inverse_velocity_spm_{};
  Real exponent_{};
  [[no_unique_address]] typename TableFor<SpeedTable, Real>::type table_;
};

}  // namespace slipstack
