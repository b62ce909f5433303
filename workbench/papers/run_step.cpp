// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "sim_host/experiments/step_response.h"
#include "workbench/papers/experiment.h"
#include "workbench/papers/options.h"

namespace slipstack::workbench {
namespace {

struct StepOptions {
  SetupChoice setup;
  double force_N = 0.0;
  double seconds = 0.1;
  ExperimentOutputs outputs;
};

double or_none(double value) {
  return value > 0.0 ? value : std::nan("");
}

ExperimentResult step_result(const sim::ExperimentSetup& setup, const sim::StepResponse& found) {
  const LengthUnit unit = length_unit(found.position_m.back());
  ExperimentResult result;
  result.experiment = "step";
  result.setup = setup.title;
  if (found.turns.size() < 3) {
    result.headline =
        fmt::format("After a step of {:g} N it turns {} times: too short a ring to read a frequency.",
                    found.force_N, found.turns.size());
    result.detail = "Give --seconds for longer, or a smaller step.";
  } else {
    result.headline = fmt::format(
        "After a step of {:g} N it rings at {:.4g} Hz first and at {:.4g} Hz when the swings are small.",
        found.force_N, found.ring_Hz, found.small_Hz);
    result.detail = fmt::format(
        "The virgin curve's first slope gives f0 = {:.4g} Hz; the slope over the first encoder steps of a "
        "loop gives {:.4g} Hz.",
        found.curve_Hz, found.differentiated_Hz);
  }
  result.summary = {{"step_N", found.force_N},
                    {"ring_Hz", found.ring_Hz},
                    {"small_Hz", found.small_Hz},
                    {"curve_Hz", found.curve_Hz},
                    {"differentiated_Hz", found.differentiated_Hz}};
  ExperimentTable table{"turns",
                        "Turning points",
                        {{"turn", "turn", "", 1.0, 0},
                         {"time_s", "time", "ms", 1e3, 5},
                         {"position_m", "position", unit.label, unit.per_m, 5},
                         {"frequency_Hz", "frequency", "Hz", 1.0, 5},
                         {"damping_ratio", "ζ", "%", 100.0, 3}},
                        {}};
  for (std::size_t i = 0; i < found.turns.size(); ++i) {
    const sim::RingTurn& turn = found.turns[i];
    table.rows.push_back({static_cast<double>(i + 1), turn.time_s, turn.position_m,
                          or_none(turn.frequency_Hz), or_none(turn.damping_ratio)});
  }
  result.tables.push_back(std::move(table));
  result.charts.push_back({fmt::format("Response to a step of {:g} N", found.force_N),
                           {"Time", "ms", 1e3, false},
                           {"Position", unit.label, unit.per_m, false},
                           found.time_s,
                           {{"position", found.position_m, {}, "measured", false}},
                           false});
  return result;
}

void run_step(const std::string& command_line, const StepOptions& wanted) {
  deliver(command_line, wanted.outputs, wanted.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.setup.axis();
    progress.show("step response");
    const double force_N = wanted.force_N != 0.0 ? wanted.force_N : setup.defaults.step_N;
    return step_result(setup, sim::run_step(setup, force_N, wanted.seconds));
  });
}

}  // namespace

void define_step(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand("step", "A force step; the natural frequency from the ring");
  auto wanted = std::make_shared<StepOptions>();
  add_setup(*command, wanted->setup, "slideway");
  command->add_option("--force-N", wanted->force_N, "height of the step (default: the set-up's)")
      ->type_name("N");
  command->add_option("--seconds", wanted->seconds, "how long to watch")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_step(command_line, *wanted); });
}

}  // namespace slipstack::workbench
