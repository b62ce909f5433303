// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/linear/bounded_least_squares.h"

namespace slipstack::workbench {

/// The unknowns of a bounded fit that are at no bound; of a pair, its sum and its difference. With the
/// Cholesky factor of their normal matrix, scaled to a unit diagonal, so that its ridge does not depend on
/// units.
class FreeUnknowns {
 public:
  /// `normal`: the normal matrix of all unknowns, with the penalty; `pairs` must outlive this.
  FreeUnknowns(Eigen::MatrixXd normal, const SumDifferencePairs& pairs, const BoundedSolution& solution);

  bool empty() const { return indices_.empty(); }
  const std::vector<Eigen::Index>& indices() const { return indices_; }
  /// By which the unknowns are scaled: the inverse roots of the diagonal of the normal matrix.
  const Eigen::VectorXd& scale() const { return scale_; }
  /// Factor of the scaled normal matrix.
  const Eigen::LLT<Eigen::MatrixXd>& factor() const { return factor_; }
  /// tr(H^-1 A) for the normal matrix H of the free unknowns; `matrix`: A, symmetric, of all unknowns.
  double trace(Eigen::MatrixXd matrix) const;

 private:
  /// The part of a symmetric matrix of all unknowns, scaled.
  Eigen::MatrixXd part_of(Eigen::MatrixXd matrix) const;

  const SumDifferencePairs& pairs_;
  std::vector<Eigen::Index> indices_;
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace slipstack::workbench
