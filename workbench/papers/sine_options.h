// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/experiments/stepped_sine.h"
#include "workbench/papers/experiment.h"
#include "workbench/papers/parallel_sweeps.h"
#include "workbench/papers/setup_choice.h"

namespace slipstack::workbench {

/// Options that the experiments with stepped sines have in common.
struct SineOptions {
  SetupChoice setup;
  std::vector<double> forces_N;
  double from_Hz = 0.0;    ///< 0: the set-up's
  double to_Hz = 0.0;      ///< 0: the set-up's
  std::size_t points = 0;  ///< 0: the set-up's
  double tolerance = 1e-7;
  double settled = 1e-4;
  std::size_t most_periods = 0;  ///< 0: the set-up's
  std::size_t threads = 0;
  std::string resume;
  ExperimentOutputs outputs;

  /// With the set-up's defaults where an option was not given; up only. Throws sim::SetupError when the
  /// frequencies are no range.
  sim::SteppedSineRequest request(const sim::ExperimentSetup& set) const;
};

/// Progress line and threads of a sweep.
RunControl control_of(Progress& progress, const std::string& stage, std::size_t threads);

/// A chart over frequency of every sweep.
ExperimentChart response_chart(const std::string& title, const std::vector<double>& frequencies_Hz);
ExperimentChart phase_chart(const std::string& title, const std::vector<double>& frequencies_Hz);
/// Amplitude over force (m/N) and phase (degrees) of a sweep, frequencies rising.
std::vector<double> compliance(const sim::Sweep& sweep);
std::vector<double> phase_deg(const sim::Sweep& sweep);

}  // namespace slipstack::workbench
