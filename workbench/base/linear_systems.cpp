// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/linear_systems.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace slipstack::workbench {

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.ldlt().solve(right);
}

Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) {
  return columns.colPivHouseholderQr().solve(target);
}

Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& target) {
  return columns.colPivHouseholderQr().solve(target);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix) {
  return matrix.completeOrthogonalDecomposition().pseudoInverse();
}

}  // namespace slipstack::workbench
