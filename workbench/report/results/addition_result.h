// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/model.h"
#include "workbench/report/results/log_results.h"

// The result of `add`; the JSON, the text of the terminal and the page show it.
namespace slipstack::workbench {

struct AdditionResult {
  std::string command_line;
  std::string log;                    ///< names of the logs, separated by ", "
  std::string model_path;             ///< where the model file goes
  std::string effect;                 ///< id
  std::string title;                  ///< of the effect
  double criterion_difference = 0.0;  ///< of `after` less `before`; negative: better (evidence/criterion.h)
  FittedModel before;
  FittedModel after;  ///< with standard errors
  double noise_floor_N = 0.0;
  std::vector<LogResult> logs;  ///< of the model after; empty for a single log
  Model model;
};

std::string addition_text(const Measurement& measurement, const AdditionResult& result);
nlohmann::json addition_json(const Measurement& measurement, const AdditionResult& result);
nlohmann::json addition_page(const Measurement& measurement, const AdditionResult& result);

}  // namespace slipstack::workbench
