// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/comparison_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/axis_words.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

/// A coordinate is mentioned when it explains this share of the residual's rms or more: the share that a
/// diagnosis demands of structure too (diagnose/verdict.cpp).
constexpr double kLeastMentioned = 0.05;

}  // namespace

std::string dependence_of(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const Structure strongest = find_structure(measurement, residual_N).front();
  return strongest.error_reduction > kLeastMentioned ? strongest.description
                                                     : "what is left depends on no single coordinate";
}

std::string comparison_text(const Measurement& measurement, const ComparisonResult& result) {
  return warning_lines(result.warnings) +
         fmt::format(
             "log        {}\nmodel      {}, hash {}\neffects    {}\nerror      {} rms, {} of the {}; "
             "noise floor {}\n{}\n",
             printable(result.log), printable(result.model_path), hash_text(result.model),
             fmt::join(ids_of(result.model.terms), ", "), newtons(result.rmse_N),
             share(result.relative_error), force_word(), newtons(result.noise_floor_N),
             sentence(result.left)) +
         excerpt_line(measurement, "noise floor and what is left seen") + repair_lines(measurement) +
         log_table(result.logs);
}

json comparison_json(const Measurement& measurement, const ComparisonResult& result) {
  json data{{"log", result.log},
            {"model", result.model_path},
            {"hash", hash_text(result.model)},
            {"samples", measurement.whole_sample_count()},
            {"searched_samples", measurement.sample_count()},
            {"effects", ids_of(result.model.terms)},
            {"rmse_N", number_json(result.rmse_N)},
            {"relative_error", number_json(result.relative_error)},
            {"noise_floor_N", number_json(result.noise_floor_N)},
            {"left", result.left},
            {"repaired", repairs_json(measurement)},
            {"input_warnings", warnings_json(result.warnings)},
            {"history", history_json(result.model)}};
  if (result.logs.size() > 1) data["logs"] = logs_json(result.logs);
  return data;
}

json comparison_page(const Measurement& measurement, const ComparisonResult& result) {
  json page = report_base(result.command_line, result.log, "compare");
  page["verdict"] = {
      {"kind", "comparison"},
      {"headline", fmt::format("The model misses the measured {} by {} rms, {} of it; the noise floor is {}.",
                               force_word(), newtons(result.rmse_N), share(result.relative_error),
                               newtons(result.noise_floor_N))},
      {"detail", warning_sentences(result.warnings) + sentence(result.left)}};
  page["figures"] = {{"noise_floor_N", number_json(result.noise_floor_N)},
                     {"train_rmse_N", number_json(result.rmse_N)},
                     {"relative_error", number_json(result.relative_error)}};
  page["baseline_effects"] = ids_of(result.model.terms);
  page["parameters"] = parameters_json(result.model.terms);
  add_pictures(page, measurement, result.rows, nullptr);
  add_logs(page, result.logs);
  add_history(page, result.model);
  return page;
}

}  // namespace slipstack::workbench
