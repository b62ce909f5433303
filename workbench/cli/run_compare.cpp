// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/report/html.h"
#include "workbench/report/results.h"
#include "workbench/report/text_tables.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// What must be explained of the residual by one coordinate for it to be worth a word.
constexpr double kLeastMentioned = 0.05;

struct Comparison {
  ForceRows rows;
  double error_N = 0.0;
  double relative = 0.0;
  double floor_N = 0.0;
  std::vector<LogResult> logs;
  std::string left;
};

/// The model as it is against the log: nothing is fitted.
Comparison compared(LogSearch& logs, const Model& model) {
  const Measurement& measurement = logs.measurement();
  Comparison result;
  Terms terms = model.terms;
  const bool several = measurement.log_count() > 1;  // each with the load that it declares
  if (several) terms = terms_on(measurement, model.terms);
  result.rows = {measurement.force_N(measurement_dynamics_of(terms)),
                 measurement.filtered(evaluate_force(measurement, terms).force_N)};
  const Eigen::VectorXd& usable = measurement.row_usable();
  const Eigen::VectorXd residual = result.rows.residual_N().cwiseProduct(usable);
  result.error_N = measurement.weighted_rms(residual);
  result.relative = residual.norm() / std::max(result.rows.measured_N.cwiseProduct(usable).norm(), 1e-300);
  std::vector<LogErrors> whole_errors;
  if (measurement.is_excerpt()) {
    WholeLogs::Residual left = logs.residuals_of({terms}).front();
    result.error_N = left.rmse_N;
    result.relative = left.relative_error;
    whole_errors = std::move(left.logs);
  }
  const NoiseFloor floor(measurement);
  result.floor_N = floor.of(terms);
  result.logs = log_results(measurement, result.rows, floor.of_each_log(terms), nullptr, whole_errors);
  const auto structure = find_structure(measurement, residual);
  result.left = structure.front().error_reduction > kLeastMentioned
                    ? structure.front().description
                    : "what is left depends on no single coordinate";
  return result;
}

json report_of(const Options& options, const Measurement& measurement, const Model& model,
               const Comparison& found) {
  json data = report_base(options.command_line, options.log, "compare");
  data["verdict"] = {
      {"kind", "comparison"},
      {"headline",
       fmt::format("The model misses the measured force by {} rms, {} of it; the noise floor is {}.",
                   newtons(found.error_N), share(found.relative), newtons(found.floor_N))},
      {"detail", sentence(found.left)}};
  data["figures"] = {{"noise_floor_N", number_json(found.floor_N)},
                     {"train_rmse_N", number_json(found.error_N)},
                     {"relative_error", number_json(found.relative)}};
  data["baseline_effects"] = ids_of(model.terms);
  data["parameters"] = parameters_json(model.terms);
  add_pictures(data, measurement, found.rows, nullptr);
  add_logs(data, found.logs);
  add_history(data, model);
  return data;
}

}  // namespace

void run_compare(const Options& options) {
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.protect_input(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  const Model model = read_model(options.model);
  Progress progress;
  Comparison found;
  LogSearch logs(log_request(options), progress);
  do {
    progress.show("compare");
    found = compared(logs, model);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();

  std::string text = fmt::format(
      "log        {}\nmodel      {}, hash {}\neffects    {}\nerror      {} rms, {} of the force; noise "
      "floor {}\n{}\n",
      printable(options.log), printable(options.model), hash_text(model),
      fmt::join(ids_of(model.terms), ", "), newtons(found.error_N), share(found.relative),
      newtons(found.floor_N), sentence(found.left));
  text += excerpt_line(measurement, "noise floor and what is left seen") + repair_lines(measurement) +
          log_table(found.logs);
  json result{{"log", options.log},
              {"model", options.model},
              {"hash", hash_text(model)},
              {"samples", measurement.whole_sample_count()},
              {"searched_samples", measurement.sample_count()},
              {"effects", ids_of(model.terms)},
              {"rmse_N", number_json(found.error_N)},
              {"relative_error", number_json(found.relative)},
              {"noise_floor_N", number_json(found.floor_N)},
              {"left", found.left}};
  result["repaired"] = repairs_json(measurement);
  if (found.logs.size() > 1) result["logs"] = logs_json(found.logs);
  result["history"] = history_json(model);
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(report_of(options, measurement, model, found)));
  }
  outputs.set(options.json, json_text(result));
  progress.finish();
  outputs.commit(text);
}

}  // namespace slipstack::workbench
