// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// Solutions of small dense linear systems. Eigen compiles a factorisation anew in each source that uses it,
// which takes seconds each time; here each is compiled once.
namespace slipstack::workbench {

/// x of matrix x = right. `matrix`: n x n, symmetric, positive or negative semidefinite; its lower triangle
/// is read. `right`: n. LDL' with pivoting (Golub and Van Loan, Matrix Computations, 4.2.8), O(n^3).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

/// x of the least |columns x - target|^2. `columns`: m x n, `target`: m, or m x k for k such problems. QR
/// with column pivoting (Golub and Van Loan, 5.4.2), O(m n^2); of columns that depend on others the
/// coefficient is zero.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target);
Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& target);

/// The Moore-Penrose inverse of `matrix`, m x n, by a complete orthogonal decomposition (Golub and Van
/// Loan, 5.4.7).
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix);

}  // namespace slipstack::workbench
