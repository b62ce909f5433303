// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// Squares of what a model leaves and of the measured force.
struct Squares {
  double left = 0.0;
  double measured = 0.0;
  double weighted_left = 0.0;
  double weight = 0.0;
  void add(const Squares& other);
  double relative() const;
  double rmse_N() const;
};

/// Weighted squares of what a model leaves of some samples of a log, to be looked at on their own.
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

/// How far and how fast the axis went: positions as read, the rest smoothed.
struct MotionExtremes {
  double low_m = std::numeric_limits<double>::infinity();
  double high_m = -std::numeric_limits<double>::infinity();
  double velocity_mps = 0.0;
  double acceleration_mps2 = 0.0;
  void add(const MotionExtremes& other);
  /// Of the samples [first, end) of a measurement.
  void take(const Measurement& measurement, std::size_t first, std::size_t end);
};

/// What is to be summed of whole logs.
struct SumTask {
  std::vector<Terms> models;
  std::size_t full = 0;  ///< so many of them also say what they leave
  double limit_N = 0.0;  ///< where the first model leaves more, rows pull no more than there; 0: all pull
};

/// What remains of a unit, which is blocks of one log that follow each other.
struct UnitSums {
  std::size_t log = 0;
  int first_block = 0;                     ///< among the blocks of all logs
  std::vector<NormalEquations> equations;  ///< of the unit's blocks, by model
  std::vector<Squares> squares;            ///< by model, of the full ones
  std::vector<Window> windows;             ///< of the last full model
  MotionExtremes reached;
};

// As messages between the processes of a team: what comes back is the same to the bit.
nlohmann::json to_json(const SumTask& task);
SumTask task_of(const nlohmann::json& message);
nlohmann::json to_json(const std::vector<UnitSums>& sums);
/// `models` are those of the task.
std::vector<UnitSums> sums_of(const nlohmann::json& message, const std::vector<Terms>& models);

}  // namespace slipstack::workbench
