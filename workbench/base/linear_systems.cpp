// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/linear_systems.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace slipstack::workbench {
namespace {

/// Eigen cuts its products into blocks that fit the caches of the machine, and sums in another order where
/// they are of another size: with those of two machines the diagnosis of one log (EMPS) ended with different
/// effects. With caches of one size, those of small processors, all machines compute the same.
const bool kBlocksAreThoseOfAllMachines = [] {
  constexpr std::ptrdiff_t kLevel1_bytes = 32 << 10;
  constexpr std::ptrdiff_t kLevel2_bytes = 256 << 10;
  constexpr std::ptrdiff_t kLevel3_bytes = 2 << 20;
  Eigen::setCpuCacheSizes(kLevel1_bytes, kLevel2_bytes, kLevel3_bytes);
  return true;
}();

}  // namespace

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
