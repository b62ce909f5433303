// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/frequency_options.h"

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

void add_sine_options(CLI::App& command, SineOptions& wanted, const std::string& setup, bool simulates) {
  add_setup(command, wanted.setup, setup);
  command
      .add_option("--forces-N", wanted.forces_N,
                  "force amplitudes, separated by commas (default: the set-up's)")
      ->delimiter(',')
      ->type_name("N,N,..");
  command.add_option("--from-Hz", wanted.from_Hz, "lowest frequency (default: the set-up's)")
      ->type_name("HZ");
  command.add_option("--to-Hz", wanted.to_Hz, "highest frequency (default: the set-up's)")->type_name("HZ");
  command
      .add_option("--points", wanted.points, "frequencies, evenly in the logarithm (default: the set-up's)")
      ->check(CLI::Range(2, 10000));
  if (simulates) {
    command
        .add_option("--tolerance", wanted.tolerance, "local error of the integration over the motion's size")
        ->check(CLI::Range(1e-12, 1e-3))
        ->capture_default_str();
    command.add_option("--settled", wanted.settled, "change of the fundamental that may be left to come")
        ->check(CLI::Range(1e-8, 0.1))
        ->capture_default_str();
    command
        .add_option("--most-periods", wanted.most_periods,
                    "patience at one frequency (default: the set-up's)")
        ->check(CLI::Range(4, 1000000));
    command
        .add_option("--threads", wanted.threads,
                    "processors to use (default: all); the result does not change")
        ->check(CLI::Range(1, 1024));
    add_word(command, "--resume", wanted.resume, "FILE",
             "where a sweep stopped by Ctrl-C is kept and taken up again");
  }
  add_experiment_outputs(command, wanted.outputs);
}

sim::Watch watch_of(Progress& progress, const SineOptions& wanted, const std::string& stage) {
  sim::Watch watch;
  watch.threads = wanted.threads;
  progress.show(stage, 0.0);
  watch.progress = [&progress, stage](double share) { progress.show(stage, share); };
  return watch;
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
