// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace slipstack::workbench {

/// left' right, of matrices with many rows and few columns, by the widest vectors of this machine. The order
/// of the sums does not depend on it. Cost: rows x columns x columns.
Eigen::MatrixXd tall_product(const Eigen::Ref<const Eigen::MatrixXd>& left,
                             const Eigen::Ref<const Eigen::MatrixXd>& right);
/// matrix factors, of a matrix with many rows, by the widest vectors of this machine. Cost: rows x the
/// columns whose factor is not zero.
Eigen::VectorXd tall_combination(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                                 const Eigen::Ref<const Eigen::VectorXd>& factors);
/// matrix' diag(weights) matrix, of which each half is computed once.
Eigen::MatrixXd weighted_gram(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                              const Eigen::Ref<const Eigen::VectorXd>& weights);

}  // namespace slipstack::workbench
