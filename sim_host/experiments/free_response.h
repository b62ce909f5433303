// SPDX-License-Identifier: Apache-2.0
// The autonomous response: a mass released from a point of the virgin curve.
#pragma once

#include <cstddef>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

struct TurningPoint {
  double time_s = 0.0;
  double position_m = 0.0;  // from the relaxed position
  double force_N = 0.0;     // pre-sliding hysteresis
  double check_m = 0.0;     // exact: by the energy balance; else: by a coarser integration
};

struct FreeResponse {
  bool exact = true;  // event-exact, with energies; else integrated by Runge-Kutta steps
  std::vector<TurningPoint> turning_points;
  std::vector<double> time_s;
  std::vector<double> position_m;
  double start_energy_J = 0.0;
  double imbalance_J = 0.0;  // work − kinetic − stored − dissipated
};

/// Moves the axis quasi-statically by `release_m`, releases it, and follows it for at most `count` turning
/// points ([1] Fig. 2); fewer when it comes to rest before.
///
/// With mass and hysteresis only it is followed event-exactly. On a branch after a reversal with force F_m
/// the friction is F_m ∓ 2·y(w/2) after a distance w, so the mass comes to rest where F_m·w = 4·∫₀^{w/2} y;
/// check_m follows from that alone. With other effects it is integrated (SmoothAxis, 1e-10), and once more at
/// 1e-8: check_m is the turning point of that run.
///
/// Throws SetupError when the release is not positive or leaves the stroke.
FreeResponse run_free(const ExperimentSetup& setup, double release_m, std::size_t count);

}  // namespace slipstack::sim
