// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

// How the contributions of the effects compose to one force (firmware/effects/effect.h):
//
//   force = [ sum(force) + sum(dry) * prod_e(1 + sum(dry_scale of e)) ] * prod_e(1 + sum(total_scale of e))
//
// The fit and the simulation use these functions. The tick has its own form of the rule, which also
// attributes the force to the effects (firmware/effects/model.h); tests/unit/estimate/what_runs_test.cpp
// compares the two.
namespace slipstack::workbench {

/// The one of four values that belongs to gains that act so.
template <class T>
T& by_acts(Acts acts, T& force, T& dry, T& dry_scale, T& total_scale) {
  switch (acts) {
    case Acts::force:
      return force;
    case Acts::dry:
      return dry;
    case Acts::dry_scale:
      return dry_scale;
    default:
      return total_scale;
  }
}

/// Friction before the modulation of the whole force. `plain_N`: sum of `force`, `dry_N`: sum of `dry`.
inline double composed_friction_N(double plain_N, double dry_N, double dry_factor) {
  return plain_N + dry_N * dry_factor;
}

/// The force of a model at one instant, composed.
struct ComposedForce {
  double dry_N = 0.0;         ///< sum of `dry`, not modulated
  double dry_factor = 1.0;    ///< product of 1 + sum(dry_scale) over the effects
  double total_factor = 1.0;  ///< product of 1 + sum(total_scale) over the effects
  double force_N = 0.0;       ///< of the whole model

  /// Derivative of force_N by the sum of gain x basis of one effect that acts so. `own_factor`: that effect's
  /// own factor 1 + sum(dry_scale) or 1 + sum(total_scale); one where it is not in the model.
  double derivative(Acts acts, double own_factor) const {
    switch (acts) {
      case Acts::force:
        return total_factor;
      case Acts::dry:
        return dry_factor * total_factor;
      case Acts::dry_scale:
        return dry_N * dry_factor * total_factor / own_factor;
      default:
        return force_N / own_factor;
    }
  }
};

}  // namespace slipstack::workbench
