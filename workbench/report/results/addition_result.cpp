// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/addition_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/report/fit_quality.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

std::string headline_of(const AdditionResult& result) {
  return fmt::format("Added {}: held-out error {} before, {} after; noise floor {}.", result.title,
                     newtons(result.before.holdout_rmse_N), newtons(result.after.holdout_rmse_N),
                     newtons(result.noise_floor_N));
}

}  // namespace

std::string addition_text(const Measurement& measurement, const AdditionResult& result) {
  std::string text = headline_of(result) + "\n";
  if (!is_worth_a_name(result.before.holdout_rmse_N, result.after.holdout_rmse_N)) {
    text += "It is no step: the held-out error falls by less than 3 %.\n";
  } else if (!is_supported(result.criterion_difference)) {
    text += fmt::format(
        "It is no step: the criterion changes by {:+.0f}, not below {:.0f}, so that its parameters may fit "
        "chance.\n",
        result.criterion_difference, -kBareMention);
  }
  return text + convergence_line(result.after.converged) + excerpt_line(measurement, "shapes fitted") +
         repair_lines(measurement) + log_table(result.logs) + parameter_table(result.after.terms) +
         friction_each_way_line(result.after) + model_lines(result.model_path, result.model);
}

json addition_json(const Measurement& measurement, const AdditionResult& result) {
  json data = written_model_json(measurement, result.after, result.noise_floor_N,
                                 {result.log, result.model_path, result.model, result.logs});
  data["added"] = result.effect;
  data["criterion_difference"] = number_json(result.criterion_difference);
  data["history"] = history_json(result.model);
  data["before"] = {{"train_rmse_N", number_json(result.before.train_rmse_N)},
                    {"holdout_rmse_N", number_json(result.before.holdout_rmse_N)},
                    {"relative_error", number_json(result.before.relative_error)}};
  return data;
}

json addition_page(const Measurement& measurement, const AdditionResult& result) {
  const FittedModel& before = result.before;
  const FittedModel& after = result.after;
  json page = report_base(result.command_line, result.log, "add");
  page["verdict"] = {{"kind", "added"}, {"headline", headline_of(result)}, {"detail", ""}};
  page["figures"] = figures_json(before, result.noise_floor_N);
  page["figures"]["holdout_interval_N"] = interval_json(before);
  page["figures"]["after_rmse_N"] = number_json(after.holdout_rmse_N);
  page["figures"]["after_interval_N"] = interval_json(after);
  page["figures"]["after_relative_error"] = number_json(after.relative_error);
  page["baseline_effects"] = ids_of(before.terms);
  page["steps"] = {{{"effect", "baseline"}, {"holdout_rmse_N", number_json(before.holdout_rmse_N)}},
                   {{"effect", result.effect}, {"holdout_rmse_N", number_json(after.holdout_rmse_N)}}};
  page["parameters"] = parameters_json(after.terms);
  add_friction_each_way(page, after);
  const ForceRows rows_after = rows_of(after);
  add_pictures(page, measurement, rows_of(before), &rows_after);
  add_logs(page, result.logs);
  add_history(page, result.model);
  return page;
}

}  // namespace slipstack::workbench
