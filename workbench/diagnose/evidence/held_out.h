// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What a regression without physics says of a residual.
struct HeldOut {
  double error_reduction = 0.0;  ///< of the residual's rms, each half judged by a fit to the other
  Eigen::VectorXd explained;     ///< by a fit to both, at the rows
};

/// Which half each row belongs to, 0 or 1; halves are made of contiguous runs.
using Halves = std::vector<std::uint8_t>;

/// Ridge regression of `residual` (rows) on `columns` (rows x unknowns).
HeldOut held_out(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual, const Halves& halves);

/// Halves of short pieces that take turns, longer than the filter's memory.
Halves alternating_blocks(Eigen::Index rows);

/// Hat functions over a coordinate: knots ascending, constant beyond the ends. Rows x knots.
Eigen::MatrixXd hat_functions(const Eigen::VectorXd& coordinate, const std::vector<double>& knots);

/// A signal with a value per sample, at the rows, unfiltered.
Eigen::VectorXd at_rows(const Measurement& measurement, const std::vector<double>& per_sample);
/// Times of the rows, s.
Eigen::VectorXd row_times(const Measurement& measurement);

}  // namespace slipstack::workbench
