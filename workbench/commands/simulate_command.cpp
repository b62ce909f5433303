// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim_host/motion/set_points.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/commands/experiment_command.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/log/log_of_table.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/model/model.h"
#include "workbench/report/results/simulation_result.h"
#include "workbench/simulate/open_loop.h"
#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {
namespace {

ExperimentResult simulate_log(const SimulateRequest& wanted, const Model& model, Progress& progress) {
  progress.show("read the log");
  const auto held = wanted.in_memory.find(wanted.log);
  const Measurement measurement(held == wanted.in_memory.end() ? read_log(wanted.log) : held->second);
  const double end_s = wanted.end_s > 0.0 ? wanted.end_s : measurement.duration_s();
  if (wanted.start_s >= end_s || end_s > measurement.duration_s() * 1.0000001) {
    throw UsageError(fmt::format("--start, --end: must lie within the {:.6g} s of the log, in this order",
                                 measurement.duration_s()));
  }
  OpenLoopOptions options{wanted.start_s, wanted.end_s,
                          [&](double fraction) { progress.show("simulate", fraction); }};
  const OpenLoop found = simulate_open_loop(measurement, terms_on(measurement, model.terms), options);
  if (!std::isfinite(found.rmse_m)) {
    throw InputError(fmt::format("{}: the simulated axis runs away; the model does not fit this log",
                                 printable(wanted.model)));
  }
  return open_loop_result(wanted.model, model, wanted.log, found, wanted.start_s,
                          measurement.sample_rate_Hz());
}

/// Set points that are in memory, with the columns of a file of them.
sim::SetPointFile set_points_of(const RawTable& table, const sim::SetPointColumns& names) {
  const auto column = [&](const std::string& name) -> const std::vector<double>* {
    const auto found = std::find_if(table.columns.begin(), table.columns.end(),
                                    [&](const RawTable::Column& one) { return one.name == name; });
    return found == table.columns.end() ? nullptr : &found->values;
  };
  const std::vector<double>* const time_s = column("time_s");
  const std::vector<double>* const position_m = column(names.position);
  if (time_s == nullptr || position_m == nullptr) {
    throw InputError(fmt::format("{}: no column {}; set points have time_s and {}", printable(table.source),
                                 time_s == nullptr ? "time_s" : names.position, names.position));
  }
  require_equal_and_finite(table);
  sim::SetPointFile points{0.0, *position_m, {}, {}};
  if (const auto* velocity = column(names.velocity)) points.velocity_mps = *velocity;
  if (const auto* acceleration = column(names.acceleration)) points.acceleration_mps2 = *acceleration;
  return sim::with_times(table.source, *time_s, std::move(points));
}

/// The motion for the axis of the model, read as the simulated axis reads it.
SetPoints set_points_of(const SimulateRequest& wanted) {
  const sim::SetPointColumns names{axis_key("position_m"), axis_key("velocity_mps"),
                                   axis_key("acceleration_mps2")};
  try {
    sim::SetPointFile file =
        wanted.points ? set_points_of(*wanted.points, names) : sim::read_set_points(wanted.set_points, names);
    return complete({file.rate_Hz, std::move(file.position_m), std::move(file.velocity_mps),
                     std::move(file.acceleration_mps2)});
  } catch (const std::runtime_error& error) {
    throw InputError(printable(error.what()));
  }
}

ExperimentResult simulate_set_points(const SimulateRequest& wanted, const Model& model, Progress& progress) {
  progress.show("read the set points");
  const SetPoints points = set_points_of(wanted);
  progress.show("simulate");
  return demand_result(wanted.model, model, wanted.set_points, points, force_along(points, model.terms));
}

void check(const SimulateRequest& wanted) {
  if (wanted.log.empty() == wanted.set_points.empty()) {
    throw UsageError(
        "simulate: give either --log, to start from its force, or --setpoints, to ask for theirs");
  }
  if (!wanted.set_points.empty() && (wanted.start_s != 0.0 || wanted.end_s != 0.0)) {
    throw UsageError("--start, --end: only with --log");
  }
  if (!(wanted.start_s >= 0.0) || !(wanted.end_s >= 0.0)) {
    throw UsageError("--start, --end: must not be negative");
  }
}

}  // namespace

CommandResult execute_simulate(const SimulateRequest& request, const ExperimentOutputs& wanted,
                               const std::string& command_line, Outputs& outputs, Progress& progress) {
  check(request);
  std::vector<std::string> inputs;
  if (!request.model_content) inputs.push_back(request.model);
  if (!request.in_memory.contains(request.log)) inputs.push_back(request.log);
  if (!request.points) inputs.push_back(request.set_points);
  return execute_experiment(wanted, inputs, command_line, outputs, [&] {
    const Model model = read_model(request.model, request.model_content);
    if (!(mass_kg(model.terms) > 0.0)) {
      throw InputError(fmt::format("{}: the model has no mass; fit it with {}", printable(request.model),
                                   effect_with_role(Role::inertia).id()));
    }
    return request.log.empty() ? simulate_set_points(request, model, progress)
                               : simulate_log(request, model, progress);
  });
}

}  // namespace slipstack::workbench
