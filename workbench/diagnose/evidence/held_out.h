// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// Result of a regression of a residual on columns without physical meaning.
struct HeldOut {
  double error_reduction = 0.0;  ///< of the residual's rms, each half predicted by a fit to the other
  Eigen::VectorXd explained;     ///< prediction at the rows by a fit to both halves
  Eigen::VectorXd value;         ///< of the unknowns, by that fit
};

/// The half that each row belongs to, 0 or 1; a half consists of contiguous runs of rows.
using Halves = std::vector<std::uint8_t>;

/// Ridge regression of `residual` (rows) on `columns` (rows x unknowns).
HeldOut held_out(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual, const Halves& halves);

/// Standard errors of linear combinations of the unknowns of that regression, one in each column of `sums`
/// (unknowns x any number): the scores are summed within each run of rows before they are squared, because
/// neighbouring rows correlate (Liang and Zeger 1986). Cost: that of held_out().
Eigen::VectorXd errors_of_sums(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                               const Halves& halves, const Eigen::MatrixXd& sums);

/// Parts of the blocks of cross-validation in turn (parts_of_block()).
Halves alternating_blocks(const Measurement& measurement);

/// A signal with a value per sample, taken at the rows without filtering.
Eigen::VectorXd at_rows(const Measurement& measurement, const std::vector<double>& per_sample);
/// The period of the motion in one part of the logs, in rows; 0 where it does not repeat.
double rows_of_period(const Measurement& measurement, const LogPart& part);
/// Times of the rows, s.
Eigen::VectorXd row_times(const Measurement& measurement);

}  // namespace slipstack::workbench
