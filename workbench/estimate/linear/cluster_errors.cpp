// SPDX-License-Identifier: Apache-2.0
// NormalEquations::standard_errors(), the wild cluster bootstrap, and recurring_variance().
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/estimate/linear/free_unknowns.h"
#include "workbench/estimate/linear/normal_equations.h"

namespace slipstack::workbench {
namespace {

/// Draws of the bootstrap: the scatter of the unknowns is then known to 5 %.
constexpr int kDraws = 200;
constexpr std::uint64_t kSeed = 1;

/// Half the width of the central 68.3 % of Student's t distribution (Abramowitz & Stegun 1964, 26.7.5): the
/// factor by which a standard error is widened when few degrees of freedom determine the size of the
/// residuals.
double student_factor(double freedom) {
  const double inverse = 1.0 / std::max(freedom, 1.0);
  return 1.0 + inverse / 2.0 + squared(inverse) / 4.0 + squared(inverse) * inverse / 16.0;
}

/// The influence of the rows of a block on each free unknown of a fit.
class Influence {
 public:
  /// `normal`: the fit's normal matrix, with its penalty.
  Influence(const Eigen::MatrixXd& normal, const SumDifferencePairs& pairs, const BoundedSolution& solution)
      : pairs_(pairs), unknowns_(normal, pairs, solution), free_(unknowns_.indices()) {
    const auto count = static_cast<Eigen::Index>(free_.size());
    inverse_ =
        scale().asDiagonal() * factor().solve(Eigen::MatrixXd::Identity(count, count)) * scale().asDiagonal();
  }

  /// The unknowns at no bound.
  const std::vector<Eigen::Index>& free() const { return free_; }

  /// X'r of a block's rows, corrected to what it would be for the noise itself. A fit follows the rows that
  /// it was made of, the more so the fewer blocks determine an unknown, and its residuals r are smaller than
  /// the noise. (I - H)^(-1/2) r, with H the block's part of the hat matrix, corrects for it (Bell &
  /// McCaffrey 2002, "CR2": unbiased variances for residuals of equal size). H = X M X' has low rank, and
  /// X'(I - H)^(-1/2) r = (I + X'X K) X'r, so that the rows need not be kept.
  Eigen::VectorXd score_of_noise(Eigen::MatrixXd gram, Eigen::VectorXd score) const {
    sum_difference_transform(pairs_, gram);
    sum_difference_transform(pairs_, score);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> hat(hat_of(gram));
    const auto leverages = hat.eigenvalues().array().max(kLeastLeverage).min(kLargestLeverage);
    const Eigen::VectorXd growth = ((1.0 - leverages).rsqrt() - 1.0) / leverages;
    Eigen::VectorXd part = factor().matrixL().solve(scale().cwiseProduct(score(free_)));
    part = hat.eigenvectors() * growth.cwiseProduct(hat.eigenvectors().transpose() * part);
    part = scale().cwiseProduct(factor().matrixU().solve(part));
    for (std::size_t i = 0; i < free_.size(); ++i) {
      score += gram.col(free_[i]) * part(static_cast<Eigen::Index>(i));
    }
    return score;
  }

  /// What a score moves each unknown by.
  Eigen::VectorXd change(Eigen::VectorXd score) const {
    sum_difference_transform(pairs_, score);
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(score.size());
    moved(free_) = inverse_ * score(free_);
    sum_difference_transform(pairs_, moved);
    return moved;
  }

  /// The block's part of the variance of each unknown, and of each sum of them, for independent residuals of
  /// equal size.
  Eigen::VectorXd information(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& sums) const {
    Eigen::MatrixXd own = gram;
    sum_difference_transform(pairs_, own);
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(gram.rows(), gram.cols());
    spread(free_, free_) = inverse_ * own(free_, free_) * inverse_;
    sum_difference_transform(pairs_, spread);
    Eigen::VectorXd variance(spread.rows() + sums.cols());
    variance << spread.diagonal(), (spread * sums).cwiseProduct(sums).colwise().sum().transpose();
    return variance;
  }

 private:
  static constexpr double kLeastLeverage = 1e-9;
  /// A block that alone determines an unknown has leverage 1: its residuals say nothing about its noise.
  static constexpr double kLargestLeverage = 0.99;

  Eigen::MatrixXd hat_of(const Eigen::MatrixXd& gram) const {
    Eigen::MatrixXd own = scale().asDiagonal() * gram(free_, free_) * scale().asDiagonal();
    factor().matrixL().solveInPlace(own);
    own.transposeInPlace();
    factor().matrixL().solveInPlace(own);
    return 0.5 * (own + own.transpose());
  }
  const Eigen::VectorXd& scale() const { return unknowns_.scale(); }
  const Eigen::LLT<Eigen::MatrixXd>& factor() const { return unknowns_.factor(); }

  const SumDifferencePairs& pairs_;
  FreeUnknowns unknowns_;
  const std::vector<Eigen::Index>& free_;
  Eigen::MatrixXd inverse_;
};

/// `value`, followed by sums of its entries.
Eigen::VectorXd with_sums(const Eigen::VectorXd& value, const Eigen::MatrixXd& sums) {
  Eigen::VectorXd all(value.size() + sums.cols());
  all << value, sums.transpose() * value;
  return all;
}

/// Sums of no unknown where there are none.
Eigen::MatrixXd sums_of(Eigen::Index unknowns, const Eigen::MatrixXd& sums) {
  return sums.size() > 0 ? sums : Eigen::MatrixXd(unknowns, 0);
}

}  // namespace

Eigen::VectorXd NormalEquations::recurring_variance(const Measurement& measurement,
                                                    const Eigen::MatrixXd& columns,
                                                    const std::vector<Eigen::VectorXd>& errors_N,
                                                    const BoundedSolution& solution,
                                                    const Constraints& constraints,
                                                    const Eigen::MatrixXd& sums) const {
  const Eigen::MatrixXd combined = sums_of(unknowns_, sums);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(unknowns_ + combined.cols());
  if (errors_N.empty()) return variance;
  const Influence influence(total_.gram + constraints.penalty, constraints.pairs, solution);
  if (influence.free().empty()) return variance;
  for (const Eigen::VectorXd& error_N : errors_N) {
    const Eigen::VectorXd weighted = measurement.fit_weights().cwiseProduct(error_N);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(variance.size());
    for (const RowRange& range : block_ranges(measurement, parts_of_block_)) {
      if (range.count == 0) continue;
      const Eigen::VectorXd moved =
          with_sums(influence.change(columns.middleRows(range.first, range.count).transpose() *
                                     weighted.segment(range.first, range.count)),
                    combined);
      sum += moved;
      variance -= moved.cwiseAbs2();
    }
    variance += sum.cwiseAbs2();
  }
  return variance.cwiseMax(0.0) / static_cast<double>(errors_N.size());
}

Eigen::VectorXd NormalEquations::standard_errors(const BoundedSolution& solution,
                                                 const Constraints& constraints,
                                                 const Eigen::MatrixXd& sums) const {
  const Eigen::MatrixXd combined = sums_of(unknowns_, sums);
  const Eigen::Index count = unknowns_ + combined.cols();
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(count);
  BoundedProblem problem{
      total_.gram + constraints.penalty, {}, constraints.lower, constraints.upper, constraints.pairs};
  const Influence influence(problem.gram, constraints.pairs, solution);
  if (influence.free().empty()) return errors;
  std::vector<Eigen::Index> reported = influence.free();
  for (Eigen::Index i = unknowns_; i < count; ++i) reported.push_back(i);
  std::vector<Eigen::VectorXd> scores(blocks_.size());
  std::vector<Eigen::VectorXd> shares(blocks_.size());
  parallel_for(blocks_.size(), [&](std::size_t b) {
    const Part& block = blocks_[b];
    scores[b] = influence.score_of_noise(block.gram, block.right - block.gram * solution.value);
    shares[b] = influence.information(block.gram, combined);
  });
  Eigen::VectorXd known = Eigen::VectorXd::Zero(count);
  Eigen::VectorXd known_squared = Eigen::VectorXd::Zero(count);
  for (const Eigen::VectorXd& share : shares) {
    known += share;
    known_squared += share.cwiseAbs2();
  }
  const Eigen::VectorXd middle = problem.gram * solution.value;
  std::mt19937_64 random(kSeed);
  std::vector<Eigen::VectorXd> rights(kDraws);
  for (Eigen::VectorXd& right : rights) {
    Eigen::VectorXd noise = Eigen::VectorXd::Zero(unknowns_);
    for (const Eigen::VectorXd& score : scores) noise += (random() >> 63U) != 0U ? score : -score;
    inverse_sum_difference_transform(constraints.pairs, noise);
    right = middle + noise;
  }
  // Shares of the draws, each with a problem of its own.
  constexpr std::size_t kShares = 8;
  std::vector<Eigen::VectorXd> moved(kDraws);
  parallel_for(kShares, [&](std::size_t first) {
    BoundedProblem own = problem;
    for (std::size_t draw = first; draw < rights.size(); draw += kShares) {
      own.right = std::move(rights[draw]);
      moved[draw] = with_sums(solve_bounded(own, solution.bound_states).value - solution.value, combined);
    }
  });
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(count);
  for (const Eigen::VectorXd& draw : moved) squares += draw.cwiseAbs2();
  for (const Eigen::Index i : reported) {
    // The effective number of blocks that determine this unknown, less one for its value.
    const double freedom = squared(known(i)) / std::max(known_squared(i), 1e-300) - 1.0;
    errors(i) = std::sqrt(squares(i) / kDraws) * student_factor(freedom);
  }
  return errors;
}

}  // namespace slipstack::workbench
