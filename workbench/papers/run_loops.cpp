// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_host/experiments/loops.h"
#include "workbench/papers/experiments.h"

namespace slipstack::workbench {
namespace {

/// With the set-up's values where an option was not given.
sim::LoopRequest request_of(const LoopsOptions& wanted, const sim::ExperimentSetup& setup) {
  sim::LoopRequest request;
  request.by_force = !wanted.forces_N.empty();
  request.amplitudes = request.by_force              ? wanted.forces_N
                       : wanted.amplitudes_m.empty() ? setup.defaults.loop_amplitudes_m
                                                     : wanted.amplitudes_m;
  request.positions_m = wanted.positions_m.empty() ? setup.defaults.loop_positions_m : wanted.positions_m;
  if (request.positions_m.empty()) request.positions_m = {setup.position_m};
  request.frequency_Hz = wanted.frequency_Hz != 0.0 ? wanted.frequency_Hz : setup.defaults.loop_frequency_Hz;
  request.cycles = wanted.cycles;
  request.sensors = wanted.sensors;
  request.seed = wanted.seed;
  return request;
}

ExperimentTable loops_table(const std::vector<sim::MeasuredLoop>& loops, const DisplayUnit& unit) {
  ExperimentTable table{"loops",
                        "Loops",
                        {{"position_m", "position", "mm", 1e3, 5},
                         {"amplitude_m", "amplitude", unit.label, unit.per_si, 4},
                         {"force_amplitude_N", "force", "N", 1.0, 4},
                         {"area_J", "area", "µJ", 1e6, 4},
                         {"stiffness_N_per_m", "stiffness", "N/µm", 1e-6, 4},
                         {"damping_N_per_m", "damping c·ω", "N/µm", 1e-6, 4},
                         {"damping_ratio", "ζ", "%", 100.0, 4},
                         {"closed_form_damping_ratio", "ζ of the curve", "%", 100.0, 4},
                         {"rolling", "", "", 1.0, 4}},
                        {}};
  for (const sim::MeasuredLoop& loop : loops) {
    table.rows.push_back({loop.position_m, loop.amplitude_m, loop.force_amplitude_N, loop.area_J,
                          loop.stiffness_N_per_m, loop.damping_N_per_m, loop.damping_ratio,
                          loop.closed_form_damping_ratio, std::string(loop.rolling ? "rolling" : "")});
  }
  return table;
}

void add_loop_charts(ExperimentResult& result, const std::vector<sim::MeasuredLoop>& loops,
                     const DisplayUnit& unit) {
  ExperimentChart* chart = nullptr;
  for (const sim::MeasuredLoop& loop : loops) {
    const std::string title = fmt::format("Loops at {:.4g} mm", 1e3 * loop.position_m);
    if (chart == nullptr || chart->title != title) {
      result.charts.push_back({title,
                               {"Displacement", unit.label, unit.per_si, false},
                               {"Force", "N", 1.0, false},
                               {},
                               {},
                               true});
      chart = &result.charts.back();
    }
    ChartCurve curve{fmt::format("{:.3g} {}", loop.amplitude_m * unit.per_si, unit.label), loop.force_N,
                     loop.displacement_m, "", false};
    // The polygon closes where it began.
    curve.x.push_back(curve.x.front());
    curve.y.push_back(curve.y.front());
    chart->curves.push_back(std::move(curve));
  }
}

ExperimentResult loops_result(const sim::ExperimentSetup& setup, const sim::LoopRequest& request,
                              const std::vector<sim::MeasuredLoop>& loops) {
  ExperimentResult result;
  result.experiment = "loops";
  result.setup = setup.title;
  double largest_m = 0.0;
  double low = 1.0;
  double high = 0.0;
  for (const sim::MeasuredLoop& loop : loops) {
    largest_m = std::max(largest_m, loop.amplitude_m);
    low = std::min(low, loop.damping_ratio);
    high = std::max(high, loop.damping_ratio);
  }
  const DisplayUnit unit = length_unit(largest_m);
  result.headline =
      fmt::format("{} loops at {} positions: damping ratio {:.2g} to {:.2g} %, growing with amplitude.",
                  loops.size(), request.positions_m.size(), 100.0 * low, 100.0 * high);
  result.detail = fmt::format("{} cycles averaged at {:g} Hz, by {}.", request.cycles, request.frequency_Hz,
                              request.by_force ? "force" : "displacement");
  result.summary = {{"frequency_Hz", request.frequency_Hz}, {"cycles", request.cycles}};
  result.tables.push_back(loops_table(loops, unit));
  add_loop_charts(result, loops, unit);
  return result;
}

}  // namespace

void run_loops(const std::string& command_line, const LoopsOptions& wanted) {
  run_experiment(command_line, wanted.outputs, wanted.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.setup.axis();
    const sim::LoopRequest request = request_of(wanted, setup);
    return loops_result(setup, request,
                        measure_loops(setup, request, control_of(progress, "loops", wanted.threads)));
  });
}

}  // namespace slipstack::workbench
