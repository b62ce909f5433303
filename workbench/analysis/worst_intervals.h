// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// An interval of the rows in which a residual is large, and what the axis did there.
struct WorstInterval {
  double from_s = 0.0;  ///< as row_times() counts
  double to_s = 0.0;
  double rmse_N = 0.0;
  double low_m = 0.0;  ///< range of the position
  double high_m = 0.0;
  double fastest_mps = 0.0;
};

/// Of 60 intervals of equal length, the `count` with the largest root mean square of the residual, largest
/// first.
std::vector<WorstInterval> worst_intervals(const Measurement& measurement, const Eigen::VectorXd& residual_N,
                                           std::size_t count = 5);
nlohmann::json worst_json(const std::vector<WorstInterval>& intervals);

/// Time since the axis last turned round, at each row; zero before the first reversal of a log.
Eigen::VectorXd since_reversal_s(const Measurement& measurement);

}  // namespace slipstack::workbench
