// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/fit_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/report/fit_quality.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

std::string outlier_line(const FitResult& result) {
  if (result.outliers == 0) return "";
  return fmt::format(
      "outliers   {} beyond five robust standard deviations pull no more than at five (Huber), the "
      "first at {:.3f} s\n",
      counted(static_cast<std::size_t>(result.outliers), "instant"), result.first_outlier_s);
}

/// What blocks from all over a log do not show: friction that drifts.
std::string forward_line(const FittedModel& fitted) {
  return fmt::format("forward    {} in the last third of the log, predicted by a fit to the first two\n",
                     newtons(fitted.forward_rmse_N));
}

/// Both criteria side by side.
std::string criteria_table(const SimulationFit& fit) {
  std::string text = fmt::format(
      "criterion  simulation: {} parameters refined in {} runs of {} from the {} alone{}\n\n{:<32} {:>18} "
      "{:>18}\n",
      fit.parameters, fit.runs, quantity(fit.run_s, "s"), force_word(),
      fit.converged ? "" : "; not converged", "error", "inverse dynamics", "simulation");
  const auto row = [&](const std::string& name, double CriterionErrors::*error, const auto& shown) {
    text += fmt::format("{:<32} {:>18} {:>18}\n", name, shown(fit.inverse_dynamics.*error),
                        shown(fit.simulation.*error));
  };
  const std::string force = force_word();
  row(force + " in sample", &CriterionErrors::force_N, newtons);
  row(force + " held out", &CriterionErrors::held_out_force_N, newtons);
  row(force + " forward", &CriterionErrors::forward_force_N, newtons);
  row("position in sample, whole log", &CriterionErrors::position_m, machine_length);
  row("position held out, each run", &CriterionErrors::held_out_position_m, machine_length);
  row("position forward, last third", &CriterionErrors::forward_position_m, machine_length);
  return text;
}

json criterion_json(const CriterionErrors& errors) {
  return {{"force_N", number_json(errors.force_N)},
          {"held_out_force_N", number_json(errors.held_out_force_N)},
          {"forward_force_N", number_json(errors.forward_force_N)},
          {"position_m", number_json(errors.position_m)},
          {"held_out_position_m", number_json(errors.held_out_position_m)},
          {"forward_position_m", number_json(errors.forward_position_m)}};
}

json criteria_json(const SimulationFit& fit) {
  return {{"parameters", fit.parameters},
          {"runs", fit.runs},
          {"run_s", number_json(fit.run_s)},
          {"converged", fit.converged},
          {"inverse_dynamics", criterion_json(fit.inverse_dynamics)},
          {"simulation", criterion_json(fit.simulation)}};
}

}  // namespace

std::string fit_text(const Measurement& measurement, const FitResult& result) {
  const FittedModel& fitted = result.fitted;
  return warning_lines(result.warnings) +
         fmt::format("log        {}\neffects    {}\n", printable(result.log),
                     fmt::join(result.effects, ", ")) +
         fmt::format("error      {} held out ({}), {} in sample, {} of the {}; noise floor {}\n",
                     newtons(fitted.holdout_rmse_N), interval_text(fitted), newtons(fitted.train_rmse_N),
                     share(fitted.relative_error), force_word(), newtons(result.noise_floor_N)) +
         convergence_line(fitted.converged) + forward_line(fitted) + noise_line(measurement) +
         excerpt_line(measurement, "shapes fitted") + repair_lines(measurement) + outlier_line(result) +
         (result.simulation ? criteria_table(*result.simulation) : "") + log_table(result.logs) +
         parameter_table(fitted.terms) + friction_each_way_line(fitted) +
         model_lines(result.model_path, result.model);
}

json fit_json(const Measurement& measurement, const FitResult& result) {
  json data = written_model_json(measurement, result.fitted, result.noise_floor_N,
                                 {result.log, result.model_path, result.model, result.logs});
  data["input_warnings"] = warnings_json(result.warnings);
  data["outliers"] = result.outliers;
  if (result.simulation) data["criteria"] = criteria_json(*result.simulation);
  return data;
}

json fit_page(const Measurement& measurement, const FitResult& result) {
  json page = report_base(result.command_line, result.log, "fit");
  page["verdict"] = {
      {"kind", "fit"},
      {"headline", fmt::format("Fitted: {} held-out error, noise floor {}.",
                               newtons(result.fitted.holdout_rmse_N), newtons(result.noise_floor_N))},
      {"detail", warning_sentences(result.warnings)}};
  page["figures"] = figures_json(result.fitted, result.noise_floor_N);
  page["baseline_effects"] = ids_of(result.fitted.terms);
  page["parameters"] = parameters_json(result.fitted.terms);
  add_friction_each_way(page, result.fitted);
  add_pictures(page, measurement, rows_of(result.fitted), nullptr);
  return page;
}

}  // namespace slipstack::workbench
