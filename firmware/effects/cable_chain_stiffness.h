// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/offset_force.h"

namespace slipstack {

/// Legendre polynomials over the stroke that the log showed: they leave the straight line alone, so that
/// `stiffness` is the mean slope whether or not the chain stiffens. Beyond the stroke the line goes on, and
/// they keep the value of its end: a cubic would run away.
template <class Real>
class CableChainStiffness {
 public:
  static constexpr EffectText text{
      .id = "cable_chain_stiffness",
      .title = "Cable chain stiffness or gravity of a link",
      .formula =
          "F = k (x - x0), as k x + F0, + a P2(u) + b P3(u); u = -1 .. 1 over the travel, "
          "P2 = (3 u^2 - 1)/2, P3 = (5 u^3 - 3 u)/2",
      .source = "Hooke; what a chain stiffens, as Legendre polynomials",
      .residual = "a line against position, straight or steeper towards the ends, the same both ways",
      .evidence =
          "the residual is a line against position, the same both ways: {stiffness}, {force_in_middle} in "
          "the middle of the travel (a constant offset would be part of it); at the ends of the travel it "
          "bends by {quadratic_at_ends} (square) and {cubic_at_ends} (cube)",
      .cause =
          "cable chain, hose or bellows pulling towards its unloaded length | gravity of a link over "
          "part of a turn, a hose or cable that is twisted",
      .confirm =
          "creep over the whole stroke both ways with the chain unhooked, then hooked | creep over "
          "the whole range both ways: gravity of a link vanishes with the axis vertical, a cable with "
          "the cable unhooked"};
  static constexpr std::array<GainGroup, 4> gains{{
      {"stiffness", "N/m", -1.0e6f, 1.0e6f, 1, Acts::force},
      {"force_at_zero", "N", -1.0e6f, 1.0e6f, 1, Acts::force},
      {"quadratic_at_ends", "N", -1.0e6f, 1.0e6f, 1, Acts::force},
      {"cubic_at_ends", "N", -1.0e6f, 1.0e6f, 1, Acts::force},
  }};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"stroke_start", "m", -1.0e3f, 1.0e3f, ShapeKind::position},
      {"stroke_length", "m", 1.0e-4f, 1.0e3f, ShapeKind::travel},
  }};
  /// The stiffness is negative above the horizontal, where gravity of a link falls with the angle, and of a
  /// spring beyond its dead centre; in a motion that repeats an inertia looks like that. A chain so soft that
  /// its pull is constant is an offset. It shows by its stiffness: its bend is measured in traverses of the
  /// same log, however short.
  static constexpr EffectTraits traits{.special_case = {.id = OffsetForce<Real>::text.id, .gains = 2},
                                       .constant_gain = 1,
                                       .plausible = {.seldom_negative = 0}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;
  static constexpr bool over_position = true;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>&) {
    middle_m_ = shape[0] + Real(0.5) * shape[1];
    per_m_ = Real(2) / shape[1];
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>& sample, std::span<Real, gain_count> out) {
    const Real u = approx::clamp((sample.position_m - middle_m_) * per_m_, Real(-1), Real(1));
    const Real square = u * u;
    out[0] = sample.position_m;
    out[1] = Real(1);
    out[2] = Real(1.5) * square - Real(0.5);
    out[3] = u * (Real(2.5) * square - Real(1.5));
  }

 private:
  Real middle_m_{};
  Real per_m_{};
};

}  // namespace slipstack
