// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/model.h"
#include "workbench/report/results/log_results.h"

// How well a fitted model describes the measurement.
namespace slipstack::workbench {

/// The 95 % confidence interval of the held-out error by block bootstrap.
std::string interval_text(const FittedModel& fitted);
nlohmann::json interval_json(const FittedModel& fitted);

/// Noise floor, errors and relative error: the figures on top of the report.
nlohmann::json figures_json(const FittedModel& fitted, double floor_N);

/// Says that the fit of products of gains did not converge; empty where it did.
std::string convergence_line(bool converged);

/// All that the JSON of a fit says of the model, its parameters and the measurement.
nlohmann::json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N);

/// A model that was fitted and where it went.
struct WrittenModel {
  const std::string& log;   ///< names of the logs, separated by ", "
  const std::string& path;  ///< of the model file
  const Model& model;
  const std::vector<LogResult>& logs;  ///< empty for a single log
};

/// quality_json() with the model file, its hash, the logs and the user-defined effects.
nlohmann::json written_model_json(const Measurement& measurement, const FittedModel& fitted, double floor_N,
                                  const WrittenModel& written);

}  // namespace slipstack::workbench
