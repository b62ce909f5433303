// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

struct OpenLoopOptions {
  double start_s = 0.0;  ///< the model is integrated from here on; before, it follows the measured motion
  double end_s = 0.0;    ///< 0: the end of the log
  std::function<void(double fraction)> progress;
};

/// The motion of a model that is driven by the measured force only.
struct OpenLoop {
  std::size_t first = 0;           ///< sample at which the integration starts
  std::vector<double> position_m;  ///< simulated, from `first` on
  std::vector<double> measured_m;  ///< the log's, the same samples
  double rmse_m = 0.0;
  double largest_m = 0.0;  ///< largest error
  double final_m = 0.0;    ///< error at the end, signed
  double fit = 0.0;        ///< 1 - |error| / |measured - its mean|
  int steps_per_sample = 1;
};

/// One free run (free_run.h) of a measurement of one log, from the measured position and velocity at the
/// start.
///
/// Throws std::invalid_argument without a mass, or when start and end leave nothing to simulate.
OpenLoop simulate_open_loop(const Measurement& measurement, const Terms& terms,
                            const OpenLoopOptions& options = {});

}  // namespace slipstack::workbench
