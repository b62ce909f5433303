// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/payload_mass.h"

namespace slipstack {

template <class Real>
class StructuralResonance {
 public:
  static constexpr EffectText text{
      .id = "structural_resonance",
      .title = "Structural resonance",
      .formula = "F = r q w^2 + d q' w + e a, q'' + 2 zeta w q' + w^2 q = a, w = 2 pi f0",
      .source = "second mass on a spring; [1] Fig. 14 shows such resonances beside the guideway's",
      .residual = "a spectral line that rings after fast moves and decays",
      .evidence =
          "the residual rings at {frequency} after fast moves, damping {damping}, a mass of {modal_mass} "
          "swings",
      .cause =
          "an arm, gripper or machine frame that swings against the axis; a belt or screw that yields "
          "between motor and load | a link, tool or machine frame that swings against the axis; a "
          "gear or belt that yields between motor and load",
      .confirm = "tap the arm with the axis held and look at the ring; add mass to the arm: the line falls"};
  static constexpr std::array<GainGroup, 3> gains{{
      {"modal_mass", "kg", -1.0e5f, 1.0e5f, 1, Acts::force},
      {"modal_damping_mass", "kg", -1.0e5f, 1.0e5f, 1, Acts::force},
      {"rigid_mass", "kg", -1.0e5f, 1.0e5f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"frequency", "Hz", 0.5f, 2.0e3f, ShapeKind::frequency},
      {"damping", "1", 1.0e-3f, 0.5f, ShapeKind::damping},
  }};
  /// A mode so stiff that its mass moves along is payload. One of more damping does not ring; one of less
  /// rings for hundreds of periods, which no arm does. Drives are sized for loads of up to ten times the
  /// inertia of their motor, and hardly any is beyond fifteen; where nearly all of the mass swings, the mode
  /// is only a filter of the acceleration, which smooths the effect of encoder steps.
  static constexpr EffectTraits traits{.role = Role::resonance,
                                       .special_case = {.id = PayloadMass<Real>::text.id},
                                       .axis_mass_gain = 2,
                                       .plausible = {.shape = {.shape = 1, .lower = 1.5e-3, .upper = 0.3},
                                                     .least_share_of_force = kRecorderErrs,
                                                     .most_axis_masses = 15.0}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;

  /// Exact for an acceleration held over the tick: state (w^2 q, w q') by its matrix exponential.
  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    const Real cycles = shape[0] * scales.tick_s;
    const Real zeta = shape[1];
    const Real damped = approx::square_root(Real(1) - zeta * zeta);
    const auto wave = approx::sin_cos_of_cycles(cycles * damped);
    const Real decay = approx::exp(-zeta * cycles * Real(6.2831853071795865));
    const Real ratio = zeta / damped;
    keep_ = decay * (wave.cos + ratio * wave.sin);
    couple_ = decay * wave.sin / damped;
    keep_rate_ = decay * (wave.cos - ratio * wave.sin);
  }
  void reset(const Sample<Real>&) {
    spring_mps2_ = Real(0);
    rate_mps2_ = Real(0);
  }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const Real excess = spring_mps2_ - sample.acceleration_mps2;
    const Real rate = rate_mps2_;
    const Real kept = sample.acceleration_mps2 + keep_ * excess;
    spring_mps2_ = kept + couple_ * rate;
    rate_mps2_ = keep_rate_ * rate - couple_ * excess;
    out[0] = spring_mps2_;
    out[1] = rate_mps2_;
    out[2] = sample.acceleration_mps2;
  }

  void carry_over(const StructuralResonance& from) {
    spring_mps2_ = from.spring_mps2_;
    rate_mps2_ = from.rate_mps2_;
  }

 private:
  Real keep_{};
  Real couple_{};
  Real keep_rate_{};
  Real spring_mps2_{};
  Real rate_mps2_{};
};

}  // namespace slipstack
