// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/packed_maxwell_slip.h"

namespace slipstack {

/// Stop operators of the target, and the finer set that the workbench identifies with before reducing it.
inline constexpr int kTargetElements = 10;
inline constexpr int kIdentifiedElements = 32;

/// The hysteresis of rolling guideways as a sum of stop operators with fixed slip distances: linear in the
/// stiffnesses. An element with slip distance 0 is unused and its basis is 0.
template <class Real, int Elements = kOnTarget<Real> ? kTargetElements : kIdentifiedElements>
class PreslidingHysteresis {
  static constexpr bool kPacked = std::is_same_v<Real, float> && Elements % 2 == 0;

 public:
  static constexpr EffectText text{
      .id = "presliding_hysteresis",
      .title = "Pre-sliding hysteresis (Maxwell-slip)",
      .formula = "F = sum_i k_i z_i, z_i stop operators of slip distance D_i",
      .source = "[1] rules I and II, [2], [4]; Maxwell-slip after Iwan",
      .residual = "follows the displacement since the last reversal",
      .evidence = "after each reversal the force rises over a short travel before it becomes constant",
      .cause =
          "rolling elements creep before they roll: contact stiffness and micro-slip of balls or rollers",
      .confirm =
          "slow sines of stepped amplitude at several places, from a tenth of the pre-sliding travel "
          "to three times it (on a rolling guideway one to some tens of micrometres) | slow sines of "
          "stepped amplitude at several angles, from a tenth of the pre-sliding travel to three times "
          "it"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"stiffness", "N/m", 0.0f, kUnbounded, Elements, Acts::dry},
  }};
  static constexpr EffectTraits traits{
      .role = Role::hysteresis, .in_default_baseline = true, .plannable = false};
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
    // Slip distances within the bounds of `shapes` are always taken, however fine the encoder.
    static_cast<void>(elements_.set_elements(slip, unit));
  }
  void reset(const Sample<Real>& sample) {
    elements_.reset(sample.displacement);
    if constexpr (kPacked) packed_.reset(sample.displacement);
  }
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    elements_.step(sample.displacement);
    for (std::size_t i = 0; i < Elements; ++i) {
      out[i] = static_cast<Real>(elements_.z(i)) * metres_per_displacement_;
    }
  }

  /// The controller's form: two elements in a word, displacement in counts. Slip distances beyond
  /// PackedMaxwellSlip::kLargestSlipDistance counts are cut there: choose the displacement unit accordingly.
  void prepare_weighted(const std::array<Real, gain_count>& stiffness_N_per_m) requires kPacked {
    std::array<std::int32_t, Elements> slip{};
    std::array<Real, Elements> stiffness{};
    for (std::size_t i = 0; i < Elements; ++i) {
      slip[i] = std::min(elements_.slip_distance(i), Packed::kLargestSlipDistance);
      stiffness[i] = stiffness_N_per_m[i] * metres_per_displacement_;
    }
    // Refused are stiffnesses that are negative or not finite, which the bounds of `gains` exclude.
    static_cast<void>(packed_.set_elements(slip, stiffness));
  }
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>&) requires kPacked {
    return packed_.step(sample.displacement);
  }
  /// Takes the loading state from another parameter set of the same axis, as far as the slip distances allow.
  void carry_over(const PreslidingHysteresis& from) requires kPacked { packed_.carry_over(from.packed_); }

 private:
  struct Nothing {};
  using Packed = PackedMaxwellSlip<static_cast<std::size_t>(Elements)>;

  DisplacementOf<Real> to_displacement(Real slip_m) const {
    const Real scaled = slip_m / metres_per_displacement_;
    if constexpr (std::is_integral_v<DisplacementOf<Real>>) {
      constexpr auto kMostCounts = static_cast<Real>(1 << 29);
      return static_cast<DisplacementOf<Real>>(approx::clamp(scaled + Real(0.5), Real(0), kMostCounts));
    } else {
      return scaled;
    }
  }

  MaxwellSlip<static_cast<std::size_t>(Elements), Real, DisplacementOf<Real>> elements_;
  [[no_unique_address]] std::conditional_t<kPacked, Packed, Nothing> packed_;
  Real metres_per_displacement_{1};
};

}  // namespace slipstack
