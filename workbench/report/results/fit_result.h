// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/model.h"
#include "workbench/report/results/log_results.h"
#include "workbench/simulate/two_criteria.h"

// The result of `fit`; the JSON, the text of the terminal and the page show it.
namespace slipstack::workbench {

struct FitResult {
  std::string command_line;
  std::string log;         ///< names of the logs, separated by ", "
  std::string model_path;  ///< where the model file goes; empty: it is not written
  std::vector<std::string> effects;
  FittedModel fitted;            ///< with standard errors
  std::int64_t outliers = 0;     ///< rows that Huber's loss held back
  double first_outlier_s = 0.0;  ///< time of the first of them
  double noise_floor_N = 0.0;
  std::vector<LogResult> logs;  ///< empty for a single log
  Model model;
  std::vector<InputWarning> warnings;
  std::optional<SimulationFit> simulation;  ///< with --criterion simulation
};

std::string fit_text(const Measurement& measurement, const FitResult& result);
nlohmann::json fit_json(const Measurement& measurement, const FitResult& result);
nlohmann::json fit_page(const Measurement& measurement, const FitResult& result);

}  // namespace slipstack::workbench
