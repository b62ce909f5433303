// SPDX-License-Identifier: Apache-2.0
// The autonomous response: a mass let go from a place on the virgin curve.
#pragma once

#include <cstddef>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

struct TurningPoint {
  double time_s = 0.0;
  double position_m = 0.0;  // from where the axis was relaxed
  double force_N = 0.0;     // friction
  double balance_m = 0.0;   // where the energy balance of the branch puts it
};

struct FreeResponse {
  std::vector<TurningPoint> turns;
  std::vector<double> time_s;
  std::vector<double> position_m;
  double start_energy_J = 0.0;
  double imbalance_J = 0.0;  // work − kinetic − stored − dissipated
};

/// Moves the axis quasi-statically by `release_m`, lets it go, and follows it event-exactly for `turns`
/// turning points ([1] Fig. 2). On a branch after a reversal with force F_m the friction is F_m ∓ 2·y(w/2)
/// after a way w, so the mass comes to rest where F_m·w = 4·∫₀^{w/2} y; balance_m follows from that and from
/// nothing else. Effects that are not linear (see exact_parts()) throw SetupError.
FreeResponse run_free(const ExperimentSetup& setup, double release_m, std::size_t turns);

}  // namespace slipstack::sim
