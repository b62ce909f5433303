// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/long_logs/motion_extremes.h"

namespace slipstack::workbench {

/// Sums of squares of the residual of a model and of the measured force.
struct Squares {
  double residual = 0.0;
  double measured = 0.0;
  double weighted_residual = 0.0;
  double weight = 0.0;
  void add(const Squares& other);
  double relative() const;
  double rmse_N() const;
};

/// Weighted sum of squares of the residual of a model in a window of a log.
struct Window {
  static constexpr std::size_t kSamples = 4096;
  std::size_t log = 0;
  std::size_t index = 0;  ///< among the windows of the log
  double squares = 0.0;
  double weight = 0.0;
  std::size_t first() const { return index * kSamples; }
  std::size_t end() const { return first() + kSamples; }
  double rmse_N() const;
};

/// Which sums over whole logs are wanted.
struct SumTask {
  std::vector<Terms> models;
  std::size_t full = 0;  ///< the residuals are summed too for so many models at the front
  double limit_N = 0.0;  ///< Huber's limit of the residual of the first model; 0: no limit
};

/// The sums of a unit, which is a sequence of consecutive blocks of one log.
struct UnitSums {
  std::size_t log = 0;
  int first_block = 0;                     ///< among the blocks of all logs
  std::vector<NormalEquations> equations;  ///< of the unit's blocks, by model
  std::vector<Squares> squares;            ///< by model, of the full ones
  std::vector<Window> windows;             ///< of the last full model
  MotionExtremes reached;
};

// Messages between the processes of a group; every number arrives unchanged to the bit.
nlohmann::json to_json(const SumTask& task);
SumTask task_of(const nlohmann::json& message);
nlohmann::json to_json(const std::vector<UnitSums>& sums);
/// `models` are those of the task.
std::vector<UnitSums> sums_of(const nlohmann::json& message, const std::vector<Terms>& models);

}  // namespace slipstack::workbench
