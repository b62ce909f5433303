// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/stribeck.h"

namespace slipstack {

template <class Real>
class FrictionalLag {
 public:
  static constexpr EffectText text{
      .id = "frictional_lag",
      .title = "Frictional lag: friction follows velocity late",
      .formula = "dry friction x (1 + q), q' = (1/tau + |v|/d) (g exp(-u) + h / (1 + u) - q), u = (|v|/vs)^n",
      .source = "frictional memory of the Leuven and GMS models [4]",
      .residual = "against velocity, one branch when speeding up and another when slowing down",
      .evidence =
          "the friction falls from standstill to its level at speed over {stribeck_velocity}, by "
          "{weakening_at_standstill} of that level, {weakening_with_tail} of the level with a long tail, and "
          "follows velocity late, by a time of {lag}, over a distance of {lag_distance}",
      .cause = "the lubricant film needs time to form and to collapse",
      .confirm =
          "slow moves whose speed varies as a sine at several frequencies: the loop force-velocity opens "
          "with frequency"};
  static constexpr std::array<GainGroup, 2> gains{Stribeck<Real>::gains};
  static constexpr std::array<ShapeSpec, 4> shapes{{
      {"stribeck_velocity", "m/s", 3.0e-4f, 1.0f, ShapeKind::fading_velocity},
      {"exponent", "1", 0.4f, 3.0f, ShapeKind::exponent},
      {"lag", "s", 1.0e-4f, 1.0e3f, ShapeKind::time_constant},
      {"lag_distance", "m", 1.0e-6f, 1.0e2f, ShapeKind::lag_distance},
  }};
  /// A lag of no time is Stribeck friction. In bristle models whose level falls with velocity (LuGre, Leuven)
  /// the deflection approaches its new value over the pre-sliding travel, without any memory of a lubricant
  /// film. The memories that were measured last 1 to 50 ms (Armstrong-Helouvry, Dupont, Canudas de Wit 1994,
  /// "A survey of models, analysis tools and compensation methods", section 2); a shorter one is none, one of
  /// seconds a change over time that the velocities of the log happen to follow.
  static constexpr EffectTraits traits{.role = Role::friction_memory,
                                       .special_case = {.id = Stribeck<Real>::text.id},
                                       .plausible = {.least_memory_s = 1e-3, .most_memory_s = 2.0}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 4;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    weakening_.prepare(shape.template first<2>(), scales);
    per_tick_ = scales.tick_s / shape[2];
    per_velocity_ = scales.tick_s / shape[3];
  }
  void reset(const Sample<Real>& sample) { weakening_.basis(sample, lagged_); }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    basis_towards(steady(sample.velocity_mps), sample.velocity_mps, out);
  }
  /// What the basis follows, by the velocity alone: a program that has many samples at once computes it for
  /// all of them together, then calls basis_towards() for one after the other.
  std::array<Real, gain_count> steady(Real velocity_mps) const { return weakening_.steady(velocity_mps); }
  void basis_towards(const std::array<Real, gain_count>& steady, Real velocity_mps,
                     std::span<Real, gain_count> out) {
    follow(steady, velocity_mps);
    for (std::size_t i = 0; i < gain_count; ++i) out[i] = lagged_[i];
  }

  /// The controller reads the steady weakening from a table.
  Real weighted(const Sample<Real>& sample,
                const std::array<Real, gain_count>& weakening) requires kOnTarget<Real> {
    follow(weakening_.tabulated(sample.velocity_mps), sample.velocity_mps);
    return weakening[0] * lagged_[0] + weakening[1] * lagged_[1];
  }
  void carry_over(const FrictionalLag& from) { lagged_ = from.lagged_; }

 private:
  /// One tick of the first-order lag towards `steady`.
  void follow(const std::array<Real, gain_count>& steady, Real velocity_mps) {
    const Real rate = per_tick_ + per_velocity_ * approx::absolute(velocity_mps);
    // Exact for a rate held over the tick, to second order; never beyond the steady value.
    const Real share = rate / (Real(1) + Real(0.5) * rate);
    const Real blend = approx::select(share < Real(1), share, Real(1));
    for (std::size_t i = 0; i < gain_count; ++i) lagged_[i] = lagged_[i] + blend * (steady[i] - lagged_[i]);
  }

  Stribeck<Real> weakening_;
  Real per_tick_{};
  Real per_velocity_{};
  std::array<Real, gain_count> lagged_{};
};

}  // namespace slipstack
