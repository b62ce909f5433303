// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_host/experiments/describing_function.h"
#include "workbench/base/statistics.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/sweep_file.h"

namespace slipstack::workbench {
namespace {

using Described = std::vector<std::vector<sim::DescribedPoint>>;  // by force, by frequency

// Error of the describing function over the simulated response, amplitude and phase together.
double error_of(const sim::DescribedPoint& described, const sim::SinePoint& simulated) {
  if (described.solutions == 0) return std::nan("");
  const auto a = std::polar(described.amplitude_m, described.phase_rad);
  const auto b = std::polar(simulated.amplitude_m, simulated.phase_rad);
  return std::abs(a - b) / std::abs(b);
}

ExperimentTable points_table(const sim::SteppedSineRequest& request, const Described& described,
                             const std::vector<sim::SweepChain>& chains) {
  const double degrees = 180.0 / std::numbers::pi;
  ExperimentTable table{"points",
                        "Responses",
                        {{"force_N", "force", "N", 1.0, 5},
                         {"frequency_Hz", "frequency", "Hz", 1.0, 5},
                         {"amplitude_m", "amplitude", "µm", 1e6, 5},
                         {"phase_rad", "phase", "°", degrees, 4},
                         {"solutions", "solutions", "", 1.0, 0}},
                        {}};
  if (!chains.empty()) {
    table.columns.insert(table.columns.end(), {{"simulated_amplitude_m", "simulated", "µm", 1e6, 5},
                                               {"simulated_phase_rad", "phase", "°", degrees, 4},
                                               {"error", "error", "%", 100.0, 3}});
  }
  for (std::size_t i = 0; i < described.size(); ++i) {
    for (std::size_t k = 0; k < described[i].size(); ++k) {
      const sim::DescribedPoint& point = described[i][k];
      const bool none = point.solutions == 0;
      std::vector<Cell> row = {request.forces_N[i], point.frequency_Hz,
                               none ? std::nan("") : point.amplitude_m, none ? std::nan("") : point.phase_rad,
                               static_cast<double>(point.solutions)};
      if (!chains.empty()) {
        const sim::SinePoint& simulated = chains[i].sweeps.front().points[k];
        row.insert(row.end(), {simulated.amplitude_m, simulated.phase_rad, error_of(point, simulated)});
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

// Root mean square and largest error by force level.
ExperimentTable levels_table(const sim::ExperimentSetup& setup, const Described& described,
                             const std::vector<sim::SweepChain>& chains, double& worst_force_N) {
  ExperimentTable table{"levels",
                        "Describing function against simulation",
                        {{"force_N", "force", "N", 1.0, 5},
                         {"force_over_level", "force/saturation", "", 1.0, 3},
                         {"median_error", "median error", "%", 100.0, 3},
                         {"largest_error", "largest", "%", 100.0, 3},
                         {"largest_at_Hz", "at", "Hz", 1.0, 4}},
                        {}};
  double worst = 0.0;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    std::vector<double> errors;
    double largest = 0.0;
    double at_Hz = std::nan("");
    for (std::size_t k = 0; k < described[i].size(); ++k) {
      const double error = error_of(described[i][k], chains[i].sweeps.front().points[k]);
      if (!std::isfinite(error)) continue;
      errors.push_back(error);
      if (error > largest) {
        largest = error;
        at_Hz = described[i][k].frequency_Hz;
      }
    }
    const double middle = errors.empty() ? std::nan("") : median(std::move(errors));
    if (middle > worst) {
      worst = middle;
      worst_force_N = chains[i].force_N;
    }
    table.rows.push_back(
        {chains[i].force_N, chains[i].force_N / setup.axis.curve.saturation_N(), middle, largest, at_Hz});
  }
  return table;
}

void add_charts(ExperimentResult& result, const sim::SteppedSineRequest& request, const Described& described,
                const std::vector<sim::SweepChain>& chains) {
  ExperimentChart amplitude =
      response_chart("Amplitude: describing function, and simulated", request.frequencies_Hz);
  ExperimentChart phase = phase_chart("Phase: describing function, and simulated", request.frequencies_Hz);
  for (std::size_t i = 0; i < described.size(); ++i) {
    const std::string role = palette_role(i);
    std::vector<double> size;
    std::vector<double> angle;
    for (const sim::DescribedPoint& point : described[i]) {
      size.push_back(point.solutions == 0 ? std::nan("") : point.amplitude_m / request.forces_N[i]);
      angle.push_back(point.solutions == 0 ? std::nan("") : point.phase_rad * 180.0 / std::numbers::pi);
    }
    const std::string name = fmt::format("{:g} N", request.forces_N[i]);
    amplitude.curves.push_back({name, size, {}, role, true});
    phase.curves.push_back({name, angle, {}, role, true});
    if (chains.empty()) continue;
    amplitude.curves.push_back({name + " simulated", compliance(chains[i].sweeps.front()), {}, role, false});
    phase.curves.push_back({name + " simulated", phase_deg(chains[i].sweeps.front()), {}, role, false});
  }
  result.charts.push_back(std::move(amplitude));
  result.charts.push_back(std::move(phase));
}

}  // namespace

void run_describing_function(const std::string& command_line, const DescribingOptions& wanted) {
  run_experiment(command_line, wanted.sine.outputs, wanted.sine.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.sine.setup.axis();
    const sim::SteppedSineRequest request = wanted.sine.request(setup);
    sim::check_stepped_sine(setup, request);
    const Described described =
        describe_responses(setup, request, control_of(progress, "describing function", wanted.sine.threads));
    std::vector<sim::SweepChain> chains;
    if (!wanted.alone) {
      chains = run_kept_sweep(wanted.sine.resume, setup, request,
                              control_of(progress, "stepped sine", wanted.sine.threads));
    }
    ExperimentResult result;
    result.experiment = "describing-function";
    result.setup = setup.title;
    if (wanted.alone) {
      result.headline = "The frequency response by the describing function.";
    } else {
      double worst_force_N = 0.0;
      result.tables.push_back(levels_table(setup, described, chains, worst_force_N));
      result.headline =
          fmt::format("The describing function is worst at {:g} N, {:.2g} of the saturation level.",
                      worst_force_N, worst_force_N / setup.axis.curve.saturation_N());
      result.summary.push_back({"worst_force_N", worst_force_N});
    }
    result.summary.push_back({"saturation_N", setup.axis.curve.saturation_N()});
    result.tables.push_back(points_table(request, described, chains));
    add_charts(result, request, described, chains);
    return result;
  });
}

}  // namespace slipstack::workbench
