// SPDX-License-Identifier: Apache-2.0
// Least squares with gains that cannot be negative: stiffnesses, levels, damping.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slipstack::workbench {

struct NonnegativeFit {
  Eigen::VectorXd gains;
  double residual_norm = 0.0;  // |columns·gains − target|
};

/// Minimises |columns·g − target| over g ≥ 0; gains marked in `free` (empty: none) may have any sign.
/// solve_bounded() decides which gains are zero; the others follow by QR, without its ridge. Columns of zeros
/// get gain zero.
///
/// Cost: about 4·rows·columns² operations. Throws std::invalid_argument when sizes do not match.
NonnegativeFit nonnegative_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                         const std::vector<bool>& free = {});

}  // namespace slipstack::workbench
