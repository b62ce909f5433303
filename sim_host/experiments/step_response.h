// SPDX-License-Identifier: Apache-2.0
// The ring after a force step, and the natural frequency read from it.
#pragma once

#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

struct RingReversal {
  double time_s = 0.0;
  double position_m = 0.0;     // from the start
  double frequency_Hz = 0.0;   // of the swing that ends here: 1/(2·duration); of the first one 0
  double damping_ratio = 0.0;  // from the decrement of two swings; of the first two 0
};

struct StepResponse {
  double force_N = 0.0;
  std::vector<double> time_s;
  std::vector<double> position_m;
  std::vector<RingReversal> turning_points;
  double ring_Hz = 0.0;   // of the first whole period after the first overshoot, as one reads it from a plot
  double small_Hz = 0.0;  // of the last swings: the limit of small motion
  double curve_Hz = 0.0;  // √(k₀/m)/2π with the virgin curve's first slope
  double differentiated_Hz =
      0.0;  // √(ΔF/Δx/m)/2π from the first encoder steps of a loop: the method against which [1] advises
};

/// A step of `force_N` at time 0, followed over `duration_s` ([1] Fig. 12: 3 N, 0.1 s). Throws SetupError
/// when the force is not positive, beyond the drive, or beyond the friction's level (the axis would slide
/// away).
StepResponse run_step(const ExperimentSetup& setup, double force_N, double duration_s);

}  // namespace slipstack::sim
