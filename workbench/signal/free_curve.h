// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace slipstack::workbench {

/// Knots, ascending, of a free curve over a coordinate: at most `intervals` + 1. Each is the mean of a
/// quantile and of a place in the range, so that neither a long dwell nor an empty part of the range takes
/// most of them.
std::vector<double> knots_over(const Eigen::VectorXd& coordinate, int intervals);

/// The two linear B-splines (hat functions) that are not zero at a value: those of the knots `below` and
/// `below` + 1. Constant beyond the ends.
struct HatWeights {
  std::size_t below = 0;
  std::array<double, 2> weight{1.0, 0.0};
};
/// Cost: O(log knots). At least one knot; with one, the second weight is zero and has no knot.
HatWeights hat_weights(double value, const std::vector<double>& knots);

/// All hat functions over a coordinate. Rows x knots.
Eigen::MatrixXd hat_functions(const Eigen::VectorXd& coordinate, const std::vector<double>& knots);

}  // namespace slipstack::workbench
