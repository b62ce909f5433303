// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/bounded_least_squares.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace slipstack::workbench {
namespace {

constexpr double kRelativeRidge = 1e-11;  ///< on columns of unit norm; far below any measured correlation
constexpr double kOptimality = 1e-9;  ///< largest violation of the optimality conditions, of the right side

/// The problem with columns of unit norm, and the state of the active-set method on it.
class ActiveSet {
 public:
  ActiveSet(const BoundedProblem& problem, const std::vector<BoundState>& start)
      : problem_(problem), size_(problem.right.size()), scale_(size_) {
    for (Eigen::Index i = 0; i < size_; ++i) {
      const double norm = problem.gram(i, i);
      scale_(i) = norm > 0.0 ? 1.0 / std::sqrt(norm) : 1.0;
    }
    gram_ = scale_.asDiagonal() * problem.gram * scale_.asDiagonal();
    gram_.diagonal().array() += kRelativeRidge;
    right_ = scale_.cwiseProduct(problem.right);
    lower_ = problem.lower.cwiseQuotient(scale_);
    upper_ = problem.upper.cwiseQuotient(scale_);
    value_ = Eigen::VectorXd::Zero(size_);
    bound_states_.assign(static_cast<std::size_t>(size_), BoundState::free);
    for (Eigen::Index i = 0; i < size_; ++i) initialise(i, start);
    tolerance_ = kOptimality * std::max(right_.lpNorm<Eigen::Infinity>(), 1e-300);
  }

  BoundedSolution run() {
    const int limit = 20 * static_cast<int>(size_) + 50;
    int iteration = 0;
    bool moved = solve_free();
    for (; iteration < limit; ++iteration) {
      if (!moved && !release_most_violating()) break;
      moved = solve_free();
    }
    return {unscaled(), bound_states_, iteration};
  }

 private:
  /// The unknowns in their own units. Those at a bound get its exact value: rounded beyond it, they would be
  /// refused in a model file.
  Eigen::VectorXd unscaled() {
    Eigen::VectorXd value = scale_.cwiseProduct(value_).cwiseMax(problem_.lower).cwiseMin(problem_.upper);
    for (Eigen::Index i = 0; i < size_; ++i) {
      if (bound_states(i) == BoundState::on_lower) value(i) = problem_.lower(i);
      if (bound_states(i) == BoundState::on_upper) value(i) = problem_.upper(i);
    }
    return value;
  }

  BoundState& bound_states(Eigen::Index i) { return bound_states_[static_cast<std::size_t>(i)]; }

  /// Initial state of unknown i: that of `start` where given, else at a bound of zero or beyond, or free.
  void initialise(Eigen::Index i, const std::vector<BoundState>& start) {
    if (lower_(i) == upper_(i)) {
      bound_states(i) = BoundState::on_lower;
    } else if (start.size() == bound_states_.size()) {
      bound_states(i) = start[static_cast<std::size_t>(i)];
    } else {
      bound_states(i) = lower_(i) >= 0.0   ? BoundState::on_lower
                        : upper_(i) <= 0.0 ? BoundState::on_upper
                                           : BoundState::free;
    }
    if (bound_states(i) == BoundState::on_lower) value_(i) = lower_(i);
    if (bound_states(i) == BoundState::on_upper) value_(i) = upper_(i);
    if (bound_states(i) == BoundState::free) value_(i) = std::min(std::max(0.0, lower_(i)), upper_(i));
  }

  /// Goes to the minimum over the free unknowns, or as far towards it as the first bounds in the way; true
  /// when a bound stopped it, so that another solve is due.
  bool solve_free() {
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < size_; ++i) {
      if (bound_states(i) == BoundState::free) free.push_back(i);
    }
    if (free.empty()) return false;
    const auto count = static_cast<Eigen::Index>(free.size());
    Eigen::VectorXd rested = value_;
    for (const Eigen::Index i : free) rested(i) = 0.0;
    const Eigen::VectorXd reduced = right_ - gram_ * rested;
    Eigen::MatrixXd part(count, count);
    Eigen::VectorXd target(count);
    for (Eigen::Index a = 0; a < count; ++a) {
      target(a) = reduced(free[static_cast<std::size_t>(a)]);
      for (Eigen::Index b = 0; b < count; ++b) {
        part(a, b) = gram_(free[static_cast<std::size_t>(a)], free[static_cast<std::size_t>(b)]);
      }
    }
    target = Eigen::LLT<Eigen::MatrixXd>(part).solve(target);

    double step = 1.0;
    for (Eigen::Index a = 0; a < count; ++a) {
      const Eigen::Index i = free[static_cast<std::size_t>(a)];
      const double change = target(a) - value_(i);
      const double bound = target(a) < lower_(i) ? lower_(i) : upper_(i);
      if (target(a) < lower_(i) || target(a) > upper_(i)) {
        step = std::min(step, change == 0.0 ? 0.0 : (bound - value_(i)) / change);
      }
    }
    bool stopped = false;
    for (Eigen::Index a = 0; a < count; ++a) {
      const Eigen::Index i = free[static_cast<std::size_t>(a)];
      value_(i) += step * (target(a) - value_(i));
      if (step == 1.0) continue;
      const double slack = 1e-12 * (1.0 + std::abs(value_(i)));
      if (target(a) < lower_(i) && value_(i) <= lower_(i) + slack) {
        value_(i) = lower_(i);
        bound_states(i) = BoundState::on_lower;
        stopped = true;
      } else if (target(a) > upper_(i) && value_(i) >= upper_(i) - slack) {
        value_(i) = upper_(i);
        bound_states(i) = BoundState::on_upper;
        stopped = true;
      }
    }
    return stopped;
  }

  /// Frees the unknown that violates the optimality conditions most; false at the minimum.
  bool release_most_violating() {
    const Eigen::VectorXd descent = right_ - gram_ * value_;
    Eigen::Index worst = -1;
    double most = tolerance_;
    for (Eigen::Index i = 0; i < size_; ++i) {
      if (lower_(i) == upper_(i) || bound_states(i) == BoundState::free) continue;
      const double gain = bound_states(i) == BoundState::on_lower ? descent(i) : -descent(i);
      if (gain > most) {
        most = gain;
        worst = i;
      }
    }
    if (worst < 0) return false;
    bound_states(worst) = BoundState::free;
    return true;
  }

  const BoundedProblem& problem_;
  Eigen::Index size_;
  Eigen::VectorXd scale_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd right_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd value_;
  std::vector<BoundState> bound_states_;
  double tolerance_ = 0.0;
};

}  // namespace

void sum_difference_transform(const SumDifferencePairs& pairs, Eigen::VectorXd& vector) {
  for (const auto& [a, b] : pairs) {
    const double sum = 0.5 * (vector(a) + vector(b));
    vector(b) = 0.5 * (vector(a) - vector(b));
    vector(a) = sum;
  }
}

namespace {

void sum_difference_columns(Eigen::Index a, Eigen::Index b, Eigen::MatrixXd& rows) {
  const Eigen::VectorXd sum = 0.5 * (rows.col(a) + rows.col(b));
  rows.col(b) = 0.5 * (rows.col(a) - rows.col(b));
  rows.col(a) = sum;
}

}  // namespace

void sum_difference_transform(const SumDifferencePairs& pairs, Eigen::MatrixXd& matrix) {
  for (const auto& [a, b] : pairs) {
    sum_difference_columns(a, b, matrix);
    const Eigen::RowVectorXd row = 0.5 * (matrix.row(a) + matrix.row(b));
    matrix.row(b) = 0.5 * (matrix.row(a) - matrix.row(b));
    matrix.row(a) = row;
  }
}

void inverse_sum_difference_transform(const SumDifferencePairs& pairs, Eigen::VectorXd& vector) {
  for (const auto& [a, b] : pairs) {
    const double sum = vector(a) + vector(b);
    vector(b) = vector(a) - vector(b);
    vector(a) = sum;
  }
}

BoundedSolution solve_bounded(const BoundedProblem& problem, const std::vector<BoundState>& start) {
  if (problem.pairs.empty()) return ActiveSet(problem, start).run();
  // In sums and differences, the constraints of the pairs are simple bounds.
  BoundedProblem transformed = problem;
  transformed.pairs.clear();
  sum_difference_transform(problem.pairs, transformed.gram);
  sum_difference_transform(problem.pairs, transformed.right);
  for (const auto& [a, b] : problem.pairs) {
    transformed.lower(a) = transformed.lower(b) = 0.0;
    transformed.upper(b) = transformed.upper(a);
  }
  BoundedSolution solution = ActiveSet(transformed, start).run();
  sum_difference_transform(problem.pairs, solution.value);
  return solution;
}

}  // namespace slipstack::workbench
