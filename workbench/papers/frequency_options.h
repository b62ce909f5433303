// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/experiments/stepped_sine.h"
#include "workbench/papers/experiment.h"
#include "workbench/papers/options.h"

namespace slipstack::workbench {

/// What the experiments with stepped sines ask for.
struct SineOptions {
  SetupChoice setup;
  std::vector<double> forces_N;
  double from_Hz = 0.0;
  double to_Hz = 0.0;
  std::size_t points = 0;
  double tolerance = 1e-7;
  double settled = 1e-4;
  std::size_t most_periods = 0;  ///< 0: the set-up's
  std::size_t threads = 0;
  std::string resume;
  ExperimentOutputs outputs;

  /// With the set-up's defaults where nothing was said; up only. Throws sim::SetupError when the range is
  /// none.
  sim::SteppedSineRequest request(const sim::ExperimentSetup& set) const;
};

/// --setup, --forces-N, --from-Hz, --to-Hz, --points and, for what simulates, accuracy, threads, --resume.
void add_sine_options(CLI::App& command, SineOptions& wanted, const std::string& setup, bool simulates);

/// Progress line and threads for a sweep.
sim::Watch watch_of(Progress& progress, const SineOptions& wanted, const std::string& stage);

/// A chart over frequency of every sweep.
ExperimentChart response_chart(const std::string& title, const std::vector<double>& frequencies_Hz);
ExperimentChart phase_chart(const std::string& title, const std::vector<double>& frequencies_Hz);
/// Amplitude over force (m/N) and phase (degrees) of a sweep, frequencies rising.
std::vector<double> compliance(const sim::Sweep& sweep);
std::vector<double> phase_deg(const sim::Sweep& sweep);

}  // namespace slipstack::workbench
