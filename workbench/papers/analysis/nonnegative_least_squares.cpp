// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/nonnegative_least_squares.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "workbench/base/linear_systems.h"
#include "workbench/estimate/linear/bounded_least_squares.h"

namespace slipstack::workbench {
namespace {

using Index = std::vector<Eigen::Index>;

Eigen::MatrixXd chosen(const Eigen::MatrixXd& columns, const Index& index) {
  Eigen::MatrixXd result(columns.rows(), static_cast<Eigen::Index>(index.size()));
  for (std::size_t i = 0; i < index.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = columns.col(index[i]);
  }
  return result;
}

void put(const Eigen::VectorXd& values, const Index& index, Eigen::VectorXd& gains) {
  for (std::size_t i = 0; i < index.size(); ++i) gains[index[i]] = values[static_cast<Eigen::Index>(i)];
}

/// A column of which the unbounded ones leave less than this share carries rounding errors only.
constexpr double kLeastShare = 1e-10;
/// Rounds end when the error falls by less than this share.
constexpr double kLeastGain = 1e-6;
constexpr int kMostRounds = 50;

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& target) {
  // Eigen solves a system without columns on either side through a null pointer.
  if (columns.cols() == 0 || target.cols() == 0) return Eigen::MatrixXd::Zero(columns.cols(), target.cols());
  return solve_least_squares(columns, target);
}

/// The gains that cannot be negative, and which of them are positive. The unbounded columns are eliminated
/// first: the problem in the residuals of the other columns and of the target has the same solution (the
/// theorem of Frisch, Waugh and Lovell).
///
/// The ridge of solve_bounded() would shift gains of columns that are nearly alike. Each round therefore
/// solves for a correction of the gains from the residual that they leave (the proximal point method,
/// Rockafellar 1976): the ridge acts on the correction, which goes to zero.
BoundedSolution bounded_gains(const Eigen::MatrixXd& bounded, const Eigen::MatrixXd& unbounded,
                              const Eigen::VectorXd& target) {
  const Eigen::MatrixXd columns = bounded - unbounded * least_squares(unbounded, bounded);
  const Eigen::VectorXd rest = target - unbounded * least_squares(unbounded, target);
  BoundedProblem problem;
  problem.gram = columns.transpose() * columns;
  problem.upper = Eigen::VectorXd::Zero(columns.cols());
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    if (columns.col(i).norm() > kLeastShare * bounded.col(i).norm()) {
      problem.upper[i] = std::numeric_limits<double>::infinity();
    }
  }
  BoundedSolution found;
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(columns.cols());
  double error = rest.norm();
  for (int round = 0; round < kMostRounds; ++round) {
    problem.right = columns.transpose() * (rest - columns * gains);
    problem.lower = -gains;
    found = solve_bounded(problem, found.bound_states);
    gains = (gains + found.value).cwiseMax(0.0);
    const double before = error;
    error = (rest - columns * gains).norm();
    if (error >= (1.0 - kLeastGain) * before) break;
  }
  found.value = gains;
  return found;
}

}  // namespace

NonnegativeFit nonnegative_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                         const std::vector<bool>& free) {
  const auto count = static_cast<std::size_t>(columns.cols());
  if (columns.rows() != target.size() || (!free.empty() && free.size() != count)) {
    throw std::invalid_argument("least squares: sizes of columns, target and marks do not match");
  }
  Index bounded;
  Index unbounded;
  for (std::size_t i = 0; i < count; ++i) {
    (!free.empty() && free[i] ? unbounded : bounded).push_back(static_cast<Eigen::Index>(i));
  }
  const Eigen::MatrixXd bounded_columns = chosen(columns, bounded);
  const Eigen::MatrixXd unbounded_columns = chosen(columns, unbounded);
  const BoundedSolution found = bounded_gains(bounded_columns, unbounded_columns, target);
  Index used = unbounded;
  for (std::size_t i = 0; i < bounded.size(); ++i) {
    if (found.bound_states[i] == BoundState::free) used.push_back(bounded[i]);
  }
  NonnegativeFit fit;
  fit.gains = Eigen::VectorXd::Zero(columns.cols());
  put(least_squares(chosen(columns, used), target), used, fit.gains);
  const bool feasible =
      std::all_of(bounded.begin(), bounded.end(), [&](Eigen::Index i) { return fit.gains[i] >= 0.0; });
  if (!feasible) {
    // Columns nearly alike: without the ridge one of their gains would be negative.
    put(found.value, bounded, fit.gains);
    put(least_squares(unbounded_columns, target - bounded_columns * found.value), unbounded, fit.gains);
  }
  fit.residual_norm = (columns * fit.gains - target).norm();
  return fit;
}

}  // namespace slipstack::workbench
