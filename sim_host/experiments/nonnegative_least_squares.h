// SPDX-License-Identifier: Apache-2.0
// Least squares with gains that cannot be negative: stiffnesses, levels, damping.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slipstack::sim {

struct NonnegativeFit {
  Eigen::VectorXd gains;
  double residual_norm = 0.0;  // |columns·gains − target|
};

/// Minimises |columns·g − target| over g ≥ 0; gains marked in `free` (empty: none) may have any sign. Active
/// sets after Lawson and Hanson, Solving Least Squares Problems (1974), ch. 23, on the triangular factor of
/// the columns, each scaled to length one. Columns of zeros get gain zero.
///
/// Cost: one QR of the columns, 2·rows·columns² operations; the search works on the small factor.
/// Throws std::invalid_argument when sizes do not match.
NonnegativeFit nonnegative_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                         const std::vector<bool>& free = {});

}  // namespace slipstack::sim
