// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_host/plant/friction/maxwell_elements.h"
#include "sim_host/rng.h"
#include "workbench/base/text.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/papers/analysis/friction_models.h"
#include "workbench/papers/experiments.h"
#include "workbench/papers/loop_tables.h"

namespace slipstack::workbench {
namespace {

/// Noise of the simulated force, over the friction's level.
constexpr double kNoise = 3e-3;
/// A model counts as returned when it is within this share of its main loop.
constexpr double kReturned = 0.01;

/// A fitted model and its error on held-out data.
struct FittedModel {
  FrictionFit all;
  double held_out = 0.0;
  double returns = std::numeric_limits<double>::quiet_NaN();
};

std::vector<FittedModel> fit_all(FrictionData data, Progress& progress) {
  std::vector<FittedModel> models;
  for (const FrictionKind kind : kFrictionKinds) {
    progress.show(fmt::format("fit {}", name(kind)),
                  static_cast<double>(models.size()) / static_cast<double>(std::size(kFrictionKinds)));
    FittedModel one;
    data.fitted_rows = 0;
    one.all = fit_friction(kind, data);
    data.fitted_rows = data.force_N.size() / 2;
    one.held_out = fit_friction(kind, data).held_out_error;
    models.push_back(std::move(one));
  }
  return models;
}

std::string shape_text(const FrictionFit& fit, const SampledMotion& motion) {
  std::string text;
  const auto parameters = shapes_of(fit.kind, motion);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    text += fmt::format("{}{} = {:.3g}", i == 0 ? "" : ", ", parameters[i].name, fit.shape[i]);
  }
  if (!fit.slips_m.empty()) {
    text += fmt::format("{}{} elements", text.empty() ? "" : ", ", fit.slips_m.size());
  }
  return text;
}

ExperimentTable models_table(const std::vector<FittedModel>& models, const SampledMotion& motion) {
  ExperimentTable table{
      "models",
      "Fitted to the same data: error over the force, on all of it, and on the second half by the first",
      {{"model", "model", "", 1.0, 4},
       {"relative_error", "error", "%", 100.0, 3},
       {"held_out_error", "held out", "%", 100.0, 3},
       {"return_error", "off the main loop", "%", 100.0, 3},
       {"returns", "returns", "", 1.0, 4},
       {"shape", "shape", "", 1.0, 4}},
      {}};
  for (const FittedModel& one : models) {
    const bool known = std::isfinite(one.returns);
    // Without memory there is no small loop to close.
    const bool memory = one.all.kind != FrictionKind::kCoulombStribeck;
    table.rows.push_back({std::string(name(one.all.kind)), one.all.relative_error, one.held_out, one.returns,
                          std::string(!known                    ? "-"
                                      : !memory                 ? "has no loop"
                                      : one.returns < kReturned ? "yes"
                                                                : "no"),
                          shape_text(one.all, motion)});
  }
  return table;
}

const FittedModel& best_of(const std::vector<FittedModel>& models) {
  return *std::min_element(models.begin(), models.end(), [](const FittedModel& a, const FittedModel& b) {
    return a.held_out < b.held_out;
  });
}

ExperimentResult result_of(const std::vector<FittedModel>& models, const SampledMotion& motion,
                           const std::string& title) {
  ExperimentResult result;
  result.experiment = "models";
  result.setup = title;
  const FittedModel& best = best_of(models);
  result.headline = fmt::format("Least error on data not seen: {}, {:.3g} % of the force.",
                                name(best.all.kind), 100.0 * best.held_out);
  result.summary = {{"best", std::string(name(best.all.kind))}, {"best_held_out_error", best.held_out}};
  result.tables.push_back(models_table(models, motion));
  return result;
}

/// Force over position of every model on the motion, thinned for the chart.
ExperimentChart loops_chart_of(const std::vector<FittedModel>& models, const FrictionData& data) {
  ExperimentChart chart{"The same motion, six models",
                        {"Position", "µm", 1e6, false},
                        {"Force", "N", 1.0, false},
                        {},
                        {},
                        true};
  const std::vector<double>& x = data.motion.position_m;
  const std::size_t stride = std::max<std::size_t>(1, x.size() / 2000);
  const auto add = [&](const std::string& name, const auto& force) {
    ChartCurve curve{name, {}, {}, name == "data" ? "measured" : "", false};
    for (std::size_t i = 0; i < x.size(); i += stride) {
      curve.x.push_back(x[i]);
      curve.y.push_back(force[static_cast<Eigen::Index>(i)]);
    }
    chart.curves.push_back(std::move(curve));
  };
  add("data", data.force_N);
  for (const FittedModel& one : models) {
    const Eigen::MatrixXd columns = model_columns(one.all.kind, one.all.shape, one.all.slips_m, data.motion);
    const double offset = one.all.gains[one.all.gains.size() - 1];
    const Eigen::VectorXd force = (columns * one.all.gains.head(columns.cols())).array() + offset;
    add(std::string(name(one.all.kind)), force);
  }
  return chart;
}

/// The motion of [3], Fig. 5, on the set-up's friction.
ExperimentResult simulated(const sim::ExperimentSetup& setup, Progress& progress) {
  const double amplitude_m = 3.0 * setup.axis.curve.travel_m();
  const double speed_mps = amplitude_m;  // a loop in four seconds: quasi-static
  FrictionData data;
  data.motion = loop_motion(amplitude_m, speed_mps, true).motion;
  data.force_N.resize(static_cast<Eigen::Index>(data.motion.position_m.size()));
  sim::MaxwellElements bank = sim::MaxwellElements::sample(setup.axis.curve, setup.axis.elements);
  sim::Rng noise(1, "models");
  for (std::size_t i = 0; i < data.motion.position_m.size(); ++i) {
    bank.move_to(data.motion.position_m[i]);
    data.force_N[static_cast<Eigen::Index>(i)] =
        bank.force_N() + kNoise * bank.saturation_N() * noise.normal();
  }
  std::vector<FittedModel> models = fit_all(data, progress);
  std::vector<std::string> names;
  for (FittedModel& one : models) {
    one.returns = return_error(one.all, amplitude_m, speed_mps);
    const bool memory = one.all.kind != FrictionKind::kCoulombStribeck;
    if (memory && one.returns < kReturned) names.emplace_back(name(one.all.kind));
  }
  ExperimentResult result = result_of(models, data.motion, setup.title);
  result.headline =
      fmt::format("Back on the main loop after a small one: {}. {}", joined(names), result.headline);
  result.summary.push_back({"returning", names});
  result.charts.push_back(loops_chart_of(models, data));
  return result;
}

ExperimentResult measured(const std::string& path, Progress& progress) {
  progress.show("read the log");
  const Measurement measurement(read_guideway_log(path));
  FrictionData data;
  data.motion = {measurement.tick_s(), measurement.position_m(), measurement.velocity_mps()};
  data.force_N = measurement.force_N();
  data.observe = [&](std::span<const double> signal) { return measurement.filtered(signal); };
  const bool inertia = !measurement.log().mass_kg || *measurement.log().mass_kg > 0.0;
  if (inertia) data.others.push_back(measurement.acceleration_mps2());
  if (data.force_N.size() < 100) {
    throw InputError(
        fmt::format("{}: {} instants are left after filtering, too few to compare models; record longer",
                    printable(path), data.force_N.size()));
  }
  const std::vector<FittedModel> models = fit_all(data, progress);
  ExperimentResult result = result_of(models, data.motion, path);
  result.notes.push_back(
      inertia ? "Every model has mass, viscous friction and an offset beside it."
              : "Every model has viscous friction and an offset beside it; inertia does not count.");
  return result;
}

}  // namespace

void run_models(const std::string& command_line, const ModelsOptions& wanted) {
  const bool from_log = !wanted.log.empty();
  const std::vector<std::string> inputs = from_log ? std::vector{wanted.log} : wanted.setup.inputs();
  run_experiment(command_line, wanted.outputs, inputs, [&](Progress& progress) {
    ExperimentResult result;
    prefix_errors(from_log ? wanted.log : wanted.setup.name, [&] {
      result = from_log ? measured(wanted.log, progress) : simulated(wanted.setup.axis(), progress);
    });
    return result;
  });
}

}  // namespace slipstack::workbench
