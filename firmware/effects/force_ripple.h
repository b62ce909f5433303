// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/ripple.h"

namespace slipstack {

template <class Real>
class ForceRipple : public Ripple<Real> {
 public:
  static constexpr EffectText text{
      .id = "force_ripple",
      .title = "Force ripple (cogging)",
      .formula = "F = sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p), h = 1..4",
      .source = "detent force of a permanent-magnet linear motor, periodic in the magnet pitch",
      .residual = "repeats with position, the same in both directions and at every force",
      .evidence =
          "the residual repeats every {pitch} of position, the same in both directions, amplitude "
          "{cosine_and_sine}",
      .cause =
          "magnets attracting the iron of the motor (cogging); a ball-pass pattern of the carriage | "
          "magnets attracting the iron of the motor (cogging); gravity of a link (once a turn), an "
          "eccentric pulley, gear teeth or a wave generator",
      .confirm =
          "creep over several periods both ways with the motor off, moved by hand or by a spring | "
          "creep over several periods both ways with the motor off, moved by hand; gravity of a link "
          "vanishes with the axis vertical"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"cosine_and_sine", "N", -1.0e6f, 1.0e6f, 2 * kRippleHarmonics, Acts::force},
  }};
};

}  // namespace slipstack
