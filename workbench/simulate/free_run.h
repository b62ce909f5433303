// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Samples of one part of a measurement in which a model moves by the measured force alone. Before `first`,
/// from `warm_up` on, its effects follow the measured motion, so that their memory is known.
struct FreeRunInterval {
  std::size_t part = 0;
  std::size_t warm_up = 0;
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - first; }
};

/// Position and velocity at the start of a run, relative to the measured ones.
struct InitialState {
  double position_m = 0.0;
  double velocity_mps = 0.0;
};

/// Steps of integration per sample so that a step times the angular frequency of the mass on the stiffest
/// hysteresis is `step_times_rate`; the scheme is stable below 2, the default is chosen for accuracy. Throws
/// std::invalid_argument without a mass.
int free_run_steps(const Measurement& measurement, const Terms& terms, double step_times_rate = 0.1);

/// The position at every sample of the interval. mass x acceleration = force / factor - friction is
/// integrated by the semi-implicit Euler method; with free_run_steps() the stop operators are passive and the
/// scheme is stable. The measured force is interpolated, and read later by the delay of the model. The
/// measured motion is not used after the start, so errors accumulate. Values are not finite where the model
/// runs away. Cost: samples x steps x effects, some 0.3 us each.
std::vector<double> free_run(const Measurement& measurement, const Terms& terms,
                             const FreeRunInterval& interval, int steps_per_sample,
                             const InitialState& start = {},
                             const std::function<void(double fraction)>& progress = {});

/// Rms error of the position over some runs of any model, each from the measured initial state.
double free_run_rmse_m(const Measurement& measurement, const Terms& terms,
                       const std::vector<FreeRunInterval>& runs, int steps_per_sample);

/// The terms with the gains that they have in one of the logs.
Terms terms_of_log(const Terms& terms, std::size_t log);

}  // namespace slipstack::workbench
