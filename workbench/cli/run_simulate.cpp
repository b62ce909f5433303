// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "sim_host/motion/set_points.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/cli/define_simulate.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effects/firmware_effects.h"
#include "workbench/papers/define_papers.h"
#include "workbench/report/simulation_result.h"
#include "workbench/simulate/open_loop.h"
#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {
namespace {

struct SimulateOptions {
  std::string model;
  std::string log;
  std::string set_points;
  double start_s = 0.0;
  double end_s = 0.0;
  ExperimentOutputs outputs;
};

ExperimentResult simulate_log(const SimulateOptions& wanted, const Model& model, Progress& progress) {
  progress.show("read the log");
  const Measurement measurement(read_log(wanted.log));
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

/// The motion of a file for the axis of the model, read as the simulated axis reads it.
SetPoints set_points_of(const std::string& path) {
  try {
    sim::SetPointFile file = sim::read_set_points(
        path, {axis_key("position_m"), axis_key("velocity_mps"), axis_key("acceleration_mps2")});
    return complete({file.rate_Hz, std::move(file.position_m), std::move(file.velocity_mps),
                     std::move(file.acceleration_mps2)});
  } catch (const std::runtime_error& error) {
    throw InputError(printable(error.what()));
  }
}

ExperimentResult simulate_set_points(const SimulateOptions& wanted, const Model& model, Progress& progress) {
  progress.show("read the set points");
  const SetPoints points = set_points_of(wanted.set_points);
  progress.show("simulate");
  return demand_result(wanted.model, model, wanted.set_points, points, force_along(points, model.terms));
}

void run_simulate(const std::string& command_line, const SimulateOptions& wanted) {
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
  run_experiment(
      command_line, wanted.outputs, {wanted.model, wanted.log, wanted.set_points}, [&](Progress& progress) {
        const Model model = read_model(wanted.model);
        if (!(mass_kg(model.terms) > 0.0)) {
          throw InputError(fmt::format("{}: the model has no mass; fit it with {}", printable(wanted.model),
                                       effect_with_role(Role::inertia).id()));
        }
        return wanted.log.empty() ? simulate_set_points(wanted, model, progress)
                                  : simulate_log(wanted, model, progress);
      });
}

}  // namespace

void define_simulate(CLI::App& app, const std::string& command_line) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Run a model forward: from a log's force to the position, or from set points to the force");
  auto wanted = std::make_shared<SimulateOptions>();
  add_word(*command, "MODEL", wanted->model, "FILE", "model file")->required();
  add_word(*command, "--log", wanted->log, "FILE", "drive the model with the force of this log, open loop");
  add_word(*command, "--setpoints", wanted->set_points, "FILE",
           "a motion (time_s, position_m): the force that it asks for");
  command
      ->add_option("--start", wanted->start_s, "where the simulation begins (default: the start of the log)")
      ->type_name("S");
  command->add_option("--end", wanted->end_s, "where to stop (default: the end of the log)")->type_name("S");
  add_word(*command, "--out", wanted->outputs.out, "FILE", "write the simulated motion or force, CSV");
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_simulate(command_line, *wanted); });
}

}  // namespace slipstack::workbench
