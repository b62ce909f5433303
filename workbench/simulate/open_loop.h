// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

struct OpenLoopOptions {
  double start_s = 0.0;  ///< from where on the model runs free; before it follows the measured motion
  double end_s = 0.0;    ///< 0: the end of the log
  std::function<void(double fraction)> progress;
};

/// Where a model goes when it is given the measured force only.
struct OpenLoop {
  std::size_t first = 0;           ///< sample of the free start
  std::vector<double> position_m;  ///< simulated, from `first` on
  std::vector<double> measured_m;  ///< the log's, the same samples
  double rmse_m = 0.0;
  double largest_m = 0.0;  ///< largest error
  double final_m = 0.0;    ///< error at the end, signed
  double fit = 0.0;        ///< 1 - |error| / |measured - its mean|
  int steps_per_sample = 1;
};

/// Integrates mass x acceleration = force / factor - friction from the measured position and velocity at the
/// start, by the semi-implicit Euler rule with steps short against the stiffest hysteresis (the stop
/// operators are then passive and the scheme is stable). The measured force is interpolated, and taken later
/// by the model's delay. Nothing of the measured motion is used after the start: errors add up, as they must
/// in an open loop. Cost: samples x steps_per_sample x effects, some 0.3 us each.
///
/// Throws std::invalid_argument without a mass, or when start and end leave nothing to simulate.
OpenLoop simulate_open_loop(const Measurement& measurement, const Terms& terms,
                            const OpenLoopOptions& options = {});

}  // namespace slipstack::workbench
