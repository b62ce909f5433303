// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/results.h"

#include <fmt/format.h>

#include "workbench/cli/inputs.h"
#include "workbench/diagnose/quantity.h"
#include "workbench/identify/reduce.h"
#include "workbench/identify/standard_errors.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {

using nlohmann::json;

std::string newtons(double value_N) {
  return quantity(value_N, "N");
}

std::string share(double value) {
  return fmt::format("{:.2f} %", 100.0 * value);
}

std::string sentence(std::string words) {
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words + ".";
}

std::string json_text(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

json report_base(const Options& options, const std::string& command) {
  return {{"title", "slipstack " + command},
          {"command", printable(options.command_line)},
          {"log", printable(options.log)}};
}

json figures_json(const FittedModel& fitted, double floor_N) {
  return {{"noise_floor_N", number_json(floor_N)},
          {"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"relative_error", number_json(fitted.relative_error)}};
}

json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N) {
  json result = figures_json(fitted, floor_N);
  result["samples"] = measurement.sample_count();
  result["effects"] = ids_of(fitted.terms);
  result["parameters"] = parameters_json(fitted.terms);
  return result;
}

ForceRows rows_of(const FittedModel& fitted) {
  return {fitted.linearisation->measured_N(), fitted.linearisation->force_N()};
}

Model model_of(const Options& options, const Measurement& measurement, const FittedModel& fitted,
               double floor_N) {
  const FittedModel reduced =
      with_standard_errors(measurement, reduce_hysteresis(measurement, fitted, kTargetElements));
  Model model;
  model.source = {printable(options.log), static_cast<std::int64_t>(measurement.sample_count()),
                  fitted.holdout_rmse_N, floor_N, fitted.relative_error};
  model.terms = fitted.terms;
  model.target_terms = reduced.terms;
  model.target_holdout_rmse_N = reduced.holdout_rmse_N;
  return model;
}

std::string hash_text(const Model& model) {
  return fmt::format("{:08x}", target_hash(model));
}

std::string model_lines(const std::string& path, const Model& model) {
  std::string text = fmt::format("\nmodel      {}, hash {}\n", printable(path), hash_text(model));
  if (find_term(model.terms, "presliding_hysteresis") != nullptr) {
    text +=
        fmt::format("controller {} hysteresis elements: held-out error {} instead of {}\n", kTargetElements,
                    newtons(model.target_holdout_rmse_N), newtons(model.source.holdout_rmse_N));
  }
  return text;
}

}  // namespace slipstack::workbench
