// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/free_unknowns.h"

#include <cstddef>
#include <utility>

namespace slipstack::workbench {
namespace {

constexpr double kRidgeOfFree = 1e-11;  ///< relative, for unknowns that the rows do not tell apart

}  // namespace

FreeUnknowns::FreeUnknowns(Eigen::MatrixXd normal, const SumDifferencePairs& pairs,
                           const BoundedSolution& solution)
    : pairs_(pairs) {
  for (std::size_t i = 0; i < solution.bound_states.size(); ++i) {
    if (solution.bound_states[i] == BoundState::free) indices_.push_back(static_cast<Eigen::Index>(i));
  }
  sum_difference_transform(pairs_, normal);
  Eigen::MatrixXd own = normal(indices_, indices_);
  scale_ = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  own = scale_.asDiagonal() * own * scale_.asDiagonal();
  own.diagonal().array() += kRidgeOfFree;
  factor_.compute(own);
}

double FreeUnknowns::trace(Eigen::MatrixXd matrix) const {
  return empty() ? 0.0 : factor_.solve(part_of(std::move(matrix))).trace();
}

Eigen::MatrixXd FreeUnknowns::part_of(Eigen::MatrixXd matrix) const {
  sum_difference_transform(pairs_, matrix);
  return scale_.asDiagonal() * matrix(indices_, indices_) * scale_.asDiagonal();
}

}  // namespace slipstack::workbench
