// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "sim_host/experiments/loops.h"
#include "workbench/papers/experiment.h"
#include "workbench/papers/options.h"

namespace slipstack::workbench {
namespace {

struct LoopsOptions {
  SetupChoice setup;
  std::vector<double> amplitudes_m;
  std::vector<double> forces_N;
  std::vector<double> positions_m;
  double frequency_Hz = 0.0;
  std::size_t cycles = 10;
  bool sensors = false;
  std::uint64_t seed = 1;
  std::size_t threads = 0;
  ExperimentOutputs outputs;

  sim::LoopRequest request(const sim::ExperimentSetup& set) const {
    sim::LoopRequest wanted;
    wanted.by_force = !forces_N.empty();
    wanted.amplitudes = wanted.by_force        ? forces_N
                        : amplitudes_m.empty() ? set.defaults.loop_amplitudes_m
                                               : amplitudes_m;
    wanted.positions_m = positions_m.empty() ? set.defaults.loop_positions_m : positions_m;
    if (wanted.positions_m.empty()) wanted.positions_m = {set.position_m};
    wanted.frequency_Hz = frequency_Hz != 0.0 ? frequency_Hz : set.defaults.loop_frequency_Hz;
    wanted.cycles = cycles;
    wanted.sensors = sensors;
    wanted.seed = seed;
    return wanted;
  }
};

ExperimentTable loops_table(const std::vector<sim::MeasuredLoop>& loops, const LengthUnit& unit) {
  ExperimentTable table{"loops",
                        "Loops",
                        {{"position_m", "position", "mm", 1e3, 5},
                         {"amplitude_m", "amplitude", unit.label, unit.per_m, 4},
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
                     const LengthUnit& unit) {
  ExperimentChart* chart = nullptr;
  for (const sim::MeasuredLoop& loop : loops) {
    const std::string title = fmt::format("Loops at {:.4g} mm", 1e3 * loop.position_m);
    if (chart == nullptr || chart->title != title) {
      result.charts.push_back(
          {title, {"Displacement", unit.label, unit.per_m, false}, {"Force", "N", 1.0, false}, {}, {}, true});
      chart = &result.charts.back();
    }
    ChartCurve curve{fmt::format("{:.3g} {}", loop.amplitude_m * unit.per_m, unit.label), loop.force_N,
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
  const LengthUnit unit = length_unit(largest_m);
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

void run_loops(const std::string& command_line, const LoopsOptions& wanted) {
  deliver(command_line, wanted.outputs, wanted.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.setup.axis();
    const sim::LoopRequest request = wanted.request(setup);
    sim::Watch watch;
    watch.threads = wanted.threads;
    progress.show("loops", 0.0);
    watch.progress = [&progress](double share) { progress.show("loops", share); };
    return loops_result(setup, request, sim::run_loops(setup, request, watch));
  });
}

}  // namespace

void define_loops(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("loops", "Quasi-static hysteresis loops of stepped amplitude");
  auto wanted = std::make_shared<LoopsOptions>();
  add_setup(*command, wanted->setup, "pick_and_place");
  CLI::Option* amplitudes = command
                                ->add_option("--amplitudes-m", wanted->amplitudes_m,
                                             "displacement amplitudes (default: the set-up's)")
                                ->delimiter(',')
                                ->type_name("M,M,..");
  command
      ->add_option("--forces-N", wanted->forces_N,
                   "force amplitudes: the axis is pushed by a force sine instead")
      ->delimiter(',')
      ->type_name("N,N,..")
      ->excludes(amplitudes);
  command->add_option("--positions-m", wanted->positions_m, "where on the stroke (default: the set-up's)")
      ->delimiter(',')
      ->type_name("M,M,..");
  command->add_option("--frequency-Hz", wanted->frequency_Hz, "of the sine (default: the set-up's)")
      ->type_name("HZ");
  command->add_option("--cycles", wanted->cycles, "cycles to average")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--sensors", wanted->sensors, "measure through the set-up's sensors");
  command->add_option("--seed", wanted->seed, "of the sensors' noise")->capture_default_str();
  command
      ->add_option("--threads", wanted->threads,
                   "processors to use (default: all); the result does not change")
      ->check(CLI::Range(1, 1024));
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_loops(command_line, *wanted); });
}

}  // namespace slipstack::workbench
