// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/sine_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace slipstack::workbench {

sim::SteppedSineRequest SineOptions::request(const sim::ExperimentSetup& set) const {
  sim::SteppedSineRequest wanted;
  wanted.forces_N = forces_N.empty() ? set.defaults.forces_N : forces_N;
  const double low_Hz = from_Hz != 0.0 ? from_Hz : set.defaults.lowest_Hz;
  const double high_Hz = to_Hz != 0.0 ? to_Hz : set.defaults.highest_Hz;
  if (!(low_Hz > 0.0 && high_Hz > low_Hz)) {
    throw sim::SetupError(fmt::format(
        "frequencies from {:g} to {:g} Hz are no range; give --from-Hz above 0 and --to-Hz above it", low_Hz,
        high_Hz));
  }
  wanted.frequencies_Hz =
      sim::log_frequencies(low_Hz, high_Hz, points != 0 ? points : set.defaults.frequencies);
  wanted.tolerance = tolerance;
  wanted.settled = settled;
  wanted.most_periods = most_periods != 0 ? most_periods : set.defaults.most_periods;
  return wanted;
}

RunControl control_of(Progress& progress, const std::string& stage, std::size_t threads) {
  RunControl control;
  control.threads = threads;
  progress.show(stage, 0.0);
  control.progress = [&progress, stage](double share) { progress.show(stage, share); };
  return control;
}

ExperimentChart response_chart(const std::string& title, const std::vector<double>& frequencies_Hz) {
  return {
      title, {"Frequency", "Hz", 1.0, true}, {"Amplitude over force", "µm/N", 1e6, true}, frequencies_Hz, {},
      false};
}

ExperimentChart phase_chart(const std::string& title, const std::vector<double>& frequencies_Hz) {
  return {title, {"Frequency", "Hz", 1.0, true}, {"Phase", "°", 1.0, false}, frequencies_Hz, {}, false};
}

std::vector<double> compliance(const sim::Sweep& sweep) {
  std::vector<double> values;
  for (const sim::SinePoint& point : sweep.points) values.push_back(point.amplitude_m / sweep.force_N);
  if (!sweep.up) std::reverse(values.begin(), values.end());
  return values;
}

std::vector<double> phase_deg(const sim::Sweep& sweep) {
  std::vector<double> values;
  for (const sim::SinePoint& point : sweep.points)
    values.push_back(point.phase_rad * 180.0 / std::numbers::pi);
  if (!sweep.up) std::reverse(values.begin(), values.end());
  return values;
}

}  // namespace slipstack::workbench
