// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>

#include "sim_host/motion/set_points.h"
#include "workbench/base/errors.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/cli/define_simulate.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effects/effect_catalogue.h"
#include "workbench/papers/command_line.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/texts.h"
#include "workbench/simulate/open_loop.h"
#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {
namespace {

/// Points of a chart; a screen resolves no more.
constexpr std::size_t kChartPoints = 4000;

struct SimulateOptions {
  std::string model;
  std::string log;
  std::string set_points;
  double start_s = 0.0;
  double end_s = 0.0;
  ExperimentOutputs outputs;
};

/// Every so many values, so that no more than kChartPoints are left.
std::vector<double> thinned(const std::vector<double>& values, double scale = 1.0) {
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kChartPoints);
  std::vector<double> few;
  for (std::size_t i = 0; i < values.size(); i += stride) few.push_back(scale * values[i]);
  return few;
}

std::vector<double> times(std::size_t count, double first_s, double rate_Hz) {
  std::vector<double> time_s(count);
  for (std::size_t i = 0; i < count; ++i) time_s[i] = first_s + static_cast<double>(i) / rate_Hz;
  return time_s;
}

std::string open_loop_csv(const OpenLoop& found, const std::vector<double>& time_s) {
  std::string text = "time_s,position_m,measured_position_m\n";
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9f},{:.9f}\n", time_s[i], found.position_m[i],
                   found.measured_m[i]);
  }
  return text;
}

ExperimentResult open_loop_result(const SimulateOptions& wanted, const Model& model, const OpenLoop& found,
                                  double start_s, double rate_Hz) {
  ExperimentResult result;
  result.command = "simulate";
  result.experiment = "simulate";
  result.setup = fmt::format("{}, hash {}, on {}", wanted.model, hash_text(model), wanted.log);
  const double duration_s = static_cast<double>(found.position_m.size()) / rate_Hz;
  result.headline = fmt::format(
      "From the measured force alone the model follows the position within {:.3f} mm rms over {:.3g} s.",
      1e3 * found.rmse_m, duration_s);
  result.detail = fmt::format(
      "Largest error {:.3f} mm, at the end {:.3f} mm; {:.2f} % of the motion is followed. Open loop: nothing "
      "measured corrects it after the start, so errors of the force add up twice.",
      1e3 * found.largest_m, 1e3 * found.final_m, 100.0 * found.fit);
  result.summary = {{"log", wanted.log},
                    {"model", wanted.model},
                    {"hash", hash_text(model)},
                    {"effects", ids_of(model.terms)},
                    {"start_s", start_s},
                    {"duration_s", duration_s},
                    {"samples", found.position_m.size()},
                    {"rmse_m", found.rmse_m},
                    {"largest_error_m", found.largest_m},
                    {"final_error_m", found.final_m},
                    {"fit", found.fit},
                    {"steps_per_sample", static_cast<std::size_t>(found.steps_per_sample)}};
  const std::vector<double> time_s = times(found.position_m.size(), start_s, rate_Hz);
  std::vector<double> error_m(time_s.size());
  for (std::size_t i = 0; i < error_m.size(); ++i) error_m[i] = found.position_m[i] - found.measured_m[i];
  const ChartAxis time{"Time", "s", 1.0, false};
  result.charts.push_back({"Position, measured and from the force alone",
                           time,
                           {"Position", "mm", 1e3, false},
                           thinned(time_s),
                           {{"measured", thinned(found.measured_m), {}, "measured", false},
                            {"simulated", thinned(found.position_m), {}, "before", true}},
                           false});
  result.charts.push_back({"Error of the position",
                           time,
                           {"Error", "mm", 1e3, false},
                           thinned(time_s),
                           {{"simulated - measured", thinned(error_m), {}, "before", false}},
                           false});
  result.notes.push_back(fmt::format(
      "Semi-implicit Euler, {} steps per sample; friction by the firmware's basis functions; position and "
      "velocity at the start from the log.",
      found.steps_per_sample));
  result.file = open_loop_csv(found, time_s);
  return result;
}

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
  return open_loop_result(wanted, model, found, wanted.start_s, measurement.sample_rate_Hz());
}

/// The motion of a file, read as the simulated axis reads it.
SetPoints set_points_of(const std::string& path) {
  try {
    sim::SetPointFile file = sim::read_set_points(path);
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
  const std::vector<double> force_N = force_along(points, model.terms);
  double squares = 0.0;
  double peak_N = 0.0;
  for (const double force : force_N) {
    squares += force * force;
    peak_N = std::max(peak_N, std::abs(force));
  }
  const double rms_N = std::sqrt(squares / static_cast<double>(force_N.size()));
  ExperimentResult result;
  result.command = "simulate";
  result.experiment = "simulate";
  result.setup = fmt::format("{}, hash {}, along {}", wanted.model, hash_text(model), wanted.set_points);
  result.headline =
      fmt::format("The motion asks for {} rms and {} at most.", newtons(rms_N), newtons(peak_N));
  result.summary = {{"model", wanted.model},    {"hash", hash_text(model)}, {"effects", ids_of(model.terms)},
                    {"samples", points.size()}, {"rms_force_N", rms_N},     {"peak_force_N", peak_N}};
  const std::vector<double> time_s = times(points.size(), 0.0, points.rate_Hz);
  result.charts.push_back({"Force along the set points",
                           {"Time", "s", 1.0, false},
                           {"Force", "N", 1.0, false},
                           thinned(time_s),
                           {{"model", thinned(force_N), {}, "before", false}},
                           false});
  result.file = "time_s,position_m,force_N\n";
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    fmt::format_to(std::back_inserter(result.file), "{:.9g},{:.9f},{:.6f}\n", time_s[i], points.position_m[i],
                   force_N[i]);
  }
  return result;
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
