// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/fit_quality.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "workbench/estimate/uncertainty/block_bootstrap.h"
#include "workbench/model/term.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

std::string interval_text(const FittedModel& fitted) {
  const ConfidenceInterval interval = holdout_interval(fitted);
  return newtons(interval.low) + " to " + newtons(interval.high);
}

json interval_json(const FittedModel& fitted) {
  const ConfidenceInterval interval = holdout_interval(fitted);
  return {number_json(interval.low), number_json(interval.high)};
}

json figures_json(const FittedModel& fitted, double floor_N) {
  return {{"noise_floor_N", number_json(floor_N)},
          {"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"forward_rmse_N", number_json(fitted.forward_rmse_N)},
          {"relative_error", number_json(fitted.relative_error)}};
}

std::string convergence_line(bool converged) {
  if (converged) return "";
  return "unfinished the fit did not converge: the log hardly tells apart what two of the effects multiply; "
         "the "
         "errors are those of the gains that were reached\n";
}

json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N) {
  json result = figures_json(fitted, floor_N);
  result["samples"] = measurement.whole_sample_count();
  result["searched_samples"] = measurement.sample_count();
  result["noise"] = noise_json(measurement);
  result["repaired"] = repairs_json(measurement);
  result["holdout_interval_N"] = interval_json(fitted);
  result["converged"] = fitted.converged;
  result["effects"] = ids_of(fitted.terms);
  result["parameters"] = parameters_json(fitted.terms);
  return result;
}

json written_model_json(const Measurement& measurement, const FittedModel& fitted, double floor_N,
                        const WrittenModel& written) {
  json data = quality_json(measurement, fitted, floor_N);
  data["log"] = written.log;
  data["model"] = written.path;
  data["hash"] = hash_text(written.model);
  if (json each_way = friction_each_way_json(fitted); !each_way.is_null()) {
    data["friction_each_way"] = std::move(each_way);
  }
  if (!written.logs.empty()) data["logs"] = logs_json(written.logs);
  if (!written.model.target_user_effects.empty()) data["user_effects"] = user_effects_json(written.model);
  return data;
}

}  // namespace slipstack::workbench
