// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/ripple.h"

namespace slipstack {

template <class Real>
class MotorConstantRipple : public Ripple<Real> {
 public:
  static constexpr EffectText text{
      .id = "motor_constant_ripple",
      .title = "Motor constant that varies with position",
      .formula = "F x (1 + sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p)), h = 1..4",
      .source = "back-EMF harmonics of a linear motor; current x nominal constant misstates the force",
      .residual =
          "repeats with position and grows with the force: nothing at coasting, most while accelerating",
      .evidence =
          "the residual repeats every {pitch} of position and grows with the force, amplitude "
          "{cosine_and_sine} of it",
      .cause = "back-EMF that is not a sine, commutation offset, a weak magnet",
      .confirm = "the same move with double the payload: the ripple doubles with the force"};
  static constexpr std::array<GainGroup, 1> gains{{
      {"cosine_and_sine", "1", -0.9f, 0.9f, 2 * kRippleHarmonics, Acts::total_scale},
  }};
  static constexpr EffectTraits traits{.plausible = {.least_share_of_force = kRecorderErrs}};
};

}  // namespace slipstack
