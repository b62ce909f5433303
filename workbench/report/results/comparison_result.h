// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/model/model.h"
#include "workbench/report/results/log_results.h"

// The result of `compare`; the JSON, the text of the terminal and the page show it.
namespace slipstack::workbench {

struct ComparisonResult {
  std::string command_line;
  std::string log;  ///< names of the logs, separated by ", "
  std::string model_path;
  Model model;  ///< as it was read
  ForceRows rows;
  double rmse_N = 0.0;
  double relative_error = 0.0;
  double noise_floor_N = 0.0;
  std::vector<LogResult> logs;
  std::vector<InputWarning> warnings;
  std::string left;  ///< what the residual depends on: a sentence without its capital and its full stop
};

/// What the residual of a model depends on most, in words. `residual_N`: at the rows, zero where not usable.
std::string dependence_of(const Measurement& measurement, const Eigen::VectorXd& residual_N);

std::string comparison_text(const Measurement& measurement, const ComparisonResult& result);
nlohmann::json comparison_json(const Measurement& measurement, const ComparisonResult& result);
nlohmann::json comparison_page(const Measurement& measurement, const ComparisonResult& result);

}  // namespace slipstack::workbench
