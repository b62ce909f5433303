// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "sim_host/experiments/step_response.h"
#include "workbench/papers/experiments.h"

namespace slipstack::workbench {
namespace {

double or_none(double value) {
  return value > 0.0 ? value : std::nan("");
}

ExperimentResult step_result(const sim::ExperimentSetup& setup, const sim::StepResponse& found) {
  const DisplayUnit unit = length_unit(found.position_m.back());
  ExperimentResult result;
  result.experiment = "step";
  result.setup = setup.title;
  if (found.turning_points.size() < 3) {
    result.headline =
        fmt::format("After a step of {:g} N it turns {} times: too short a ring to read a frequency.",
                    found.force_N, found.turning_points.size());
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
  ExperimentTable table{"turning_points",
                        "Turning points",
                        {{"number", "#", "", 1.0, 0},
                         {"time_s", "time", "ms", 1e3, 5},
                         {"position_m", "position", unit.label, unit.per_si, 5},
                         {"frequency_Hz", "frequency", "Hz", 1.0, 5},
                         {"damping_ratio", "ζ", "%", 100.0, 3}},
                        {}};
  for (std::size_t i = 0; i < found.turning_points.size(); ++i) {
    const sim::RingReversal& point = found.turning_points[i];
    table.rows.push_back({static_cast<double>(i + 1), point.time_s, point.position_m,
                          or_none(point.frequency_Hz), or_none(point.damping_ratio)});
  }
  result.tables.push_back(std::move(table));
  result.charts.push_back(motion_chart(fmt::format("Response to a step of {:g} N", found.force_N),
                                       found.time_s, found.position_m, unit));
  return result;
}

}  // namespace

void run_step(const std::string& command_line, const StepOptions& wanted) {
  run_experiment(command_line, wanted.outputs, wanted.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.setup.axis();
    progress.show("step response");
    const double force_N = wanted.force_N != 0.0 ? wanted.force_N : setup.defaults.step_N;
    return step_result(setup, sim::run_step(setup, force_N, wanted.seconds));
  });
}

}  // namespace slipstack::workbench
