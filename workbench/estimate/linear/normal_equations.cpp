// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/normal_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

/// Records that are drawn to see how far the unknowns scatter: to 5 % of the standard error.
constexpr int kDraws = 200;
constexpr std::uint64_t kSeed = 1;

/// Half the width of the central 68.3 % of Student's t, which is what a standard error promises, where so few
/// degrees of freedom tell how large residuals are (Abramowitz & Stegun 1964, 26.7.5).
double wider_for(double freedom) {
  const double inverse = 1.0 / std::max(freedom, 1.0);
  return 1.0 + inverse / 2.0 + squared(inverse) / 4.0 + squared(inverse) * inverse / 16.0;
}

/// The gradient that turn() made of what this gives.
void undo_sum_and_difference(const EachWay& pairs, Eigen::VectorXd& gradient) {
  for (const auto& [a, b] : pairs) {
    const double sum = gradient(a) + gradient(b);
    gradient(b) = gradient(a) - gradient(b);
    gradient(a) = sum;
  }
}

/// What the rows of a block do to each free unknown of a fit.
class Influence {
 public:
  /// `normal`: the fit's normal matrix, with its penalty.
  Influence(Eigen::MatrixXd normal, const EachWay& each_way, std::vector<Eigen::Index> free)
      : each_way_(each_way), free_(std::move(free)) {
    turn(each_way_, normal);
    const Eigen::MatrixXd bread = normal(free_, free_);
    scale_ = bread.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale_.asDiagonal() * bread * scale_.asDiagonal();
    scaled.diagonal().array() += kRelativeRidge;
    factor_.compute(scaled);
    inverse_ = scale_.asDiagonal() * factor_.solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.rows())) *
               scale_.asDiagonal();
  }

  /// X'r of a block's rows as it would be of the noise itself. A fit bends towards the rows that it has, the
  /// more the fewer blocks tell of an unknown, and leaves too little of their noise: (I - H)^(-1/2) r, H the
  /// block's part of the hat matrix, makes up for it (Bell & McCaffrey 2002, "CR2": variances without bias
  /// where residuals are alike). H = X M X' has few directions, and X'(I - H)^(-1/2) r = (I + X'X K) X'r, so
  /// that rows need not be kept.
  Eigen::VectorXd score_of_noise(Eigen::MatrixXd gram, Eigen::VectorXd score) const {
    turn(each_way_, gram);
    turn(each_way_, score);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> hat(hat_of(gram));
    const auto bends = hat.eigenvalues().array().max(kNothing).min(kMost);
    const Eigen::VectorXd more = ((1.0 - bends).rsqrt() - 1.0) / bends;
    Eigen::VectorXd part = factor_.matrixL().solve(scale_.cwiseProduct(score(free_)));
    part = hat.eigenvectors() * more.cwiseProduct(hat.eigenvectors().transpose() * part);
    part = scale_.cwiseProduct(factor_.matrixU().solve(part));
    for (std::size_t i = 0; i < free_.size(); ++i) {
      score += gram.col(free_[i]) * part(static_cast<Eigen::Index>(i));
    }
    return score;
  }

  /// The block's part of each unknown's variance if residuals were alike and independent.
  Eigen::VectorXd information(const Eigen::MatrixXd& gram) const {
    Eigen::MatrixXd own = gram;
    turn(each_way_, own);
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(gram.rows(), gram.cols());
    spread(free_, free_) = inverse_ * own(free_, free_) * inverse_;
    turn(each_way_, spread);
    return spread.diagonal();
  }

 private:
  static constexpr double kRelativeRidge = 1e-11;
  static constexpr double kNothing = 1e-9;
  /// A block that alone tells of something leaves nothing to judge it by.
  static constexpr double kMost = 0.99;

  Eigen::MatrixXd hat_of(const Eigen::MatrixXd& gram) const {
    Eigen::MatrixXd own = scale_.asDiagonal() * gram(free_, free_) * scale_.asDiagonal();
    factor_.matrixL().solveInPlace(own);
    own.transposeInPlace();
    factor_.matrixL().solveInPlace(own);
    return 0.5 * (own + own.transpose());
  }
  const EachWay& each_way_;
  std::vector<Eigen::Index> free_;
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd inverse_;
};

/// Rows of each part of a block: blocks are contiguous and in order.
std::vector<RowRange> block_ranges(const Measurement& measurement, int parts = 1) {
  std::vector<RowRange> ranges(static_cast<std::size_t>(measurement.block_count()));
  const std::vector<int>& blocks = measurement.row_blocks();
  for (std::size_t row = 0; row < blocks.size(); ++row) {
    RowRange& range = ranges[static_cast<std::size_t>(blocks[row])];
    if (range.count == 0) range.first = static_cast<Eigen::Index>(row);
    ++range.count;
  }
  if (parts == 1) return ranges;
  std::vector<RowRange> finer;
  for (const RowRange& range : ranges) {
    for (int part = 0; part < parts; ++part) {
      const Eigen::Index first = range.count * part / parts;
      finer.push_back({range.first + first, range.count * (part + 1) / parts - first});
    }
  }
  return finer;
}

/// Rows of one block, each multiplied by the root of its weight.
Eigen::MatrixXd weighted(const Measurement& measurement, const Eigen::MatrixXd& rows, const RowRange& range) {
  return measurement.row_weights().segment(range.first, range.count).cwiseSqrt().asDiagonal() *
         rows.middleRows(range.first, range.count);
}

}  // namespace

void NormalEquations::Part::add(const Part& other, double sign) {
  gram += sign * other.gram;
  right += sign * other.right;
  target_squared += sign * other.target_squared;
  weight += sign * other.weight;
}

double NormalEquations::Part::squared_error(const Eigen::VectorXd& value) const {
  return std::max(0.0, target_squared - 2.0 * right.dot(value) + value.dot(gram * value));
}

NormalEquations::NormalEquations(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                 const Eigen::VectorXd& target, int parts_of_block)
    : unknowns_(columns.cols()), folds_(measurement.fold_count()) {
  for (const RowRange& range : block_ranges(measurement, parts_of_block)) {
    if (range.count == 0) {  // all of it cut; a rank update of no rows divides by their number
      blocks_.push_back(nothing(unknowns_));
      continue;
    }
    const Eigen::MatrixXd part = weighted(measurement, columns, range);
    const Eigen::VectorXd wanted = weighted(measurement, target, range);
    Part block;
    block.gram = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    block.gram.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
    block.gram = Eigen::MatrixXd(block.gram.selfadjointView<Eigen::Lower>());
    block.right = part.transpose() * wanted;
    block.target_squared = wanted.squaredNorm();
    block.weight = measurement.row_weights().segment(range.first, range.count).sum();
    blocks_.push_back(std::move(block));
  }
  sum_up();
}

NormalEquations NormalEquations::with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                      const Eigen::MatrixXd& further, const Eigen::VectorXd& target) const {
  NormalEquations wider;
  wider.unknowns_ = unknowns_ + further.cols();
  wider.folds_ = folds_;
  const std::vector<RowRange> ranges = block_ranges(measurement);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Eigen::VectorXd weights = measurement.row_weights().segment(ranges[b].first, ranges[b].count);
    const auto old_part = columns.middleRows(ranges[b].first, ranges[b].count);
    const auto new_part = further.middleRows(ranges[b].first, ranges[b].count);
    const Eigen::MatrixXd twice = weights.asDiagonal() * new_part;
    Part block;
    block.gram.resize(wider.unknowns_, wider.unknowns_);
    block.gram.topLeftCorner(unknowns_, unknowns_) = blocks_[b].gram;
    block.gram.bottomLeftCorner(further.cols(), unknowns_).noalias() = twice.transpose() * old_part;
    block.gram.topRightCorner(unknowns_, further.cols()) =
        block.gram.bottomLeftCorner(further.cols(), unknowns_).transpose();
    block.gram.bottomRightCorner(further.cols(), further.cols()).noalias() = twice.transpose() * new_part;
    block.right.resize(wider.unknowns_);
    block.right.head(unknowns_) = blocks_[b].right;
    block.right.tail(further.cols()) = twice.transpose() * target.segment(ranges[b].first, ranges[b].count);
    block.target_squared = blocks_[b].target_squared;
    block.weight = blocks_[b].weight;
    wider.blocks_.push_back(std::move(block));
  }
  wider.sum_up();
  return wider;
}

NormalEquations NormalEquations::with_target(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                             const Eigen::VectorXd& target) const {
  NormalEquations other = *this;
  const std::vector<RowRange> ranges = block_ranges(measurement);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Eigen::VectorXd wanted = weighted(measurement, target, ranges[b]);
    other.blocks_[b].right = weighted(measurement, columns, ranges[b]).transpose() * wanted;
    other.blocks_[b].target_squared = wanted.squaredNorm();
  }
  other.sum_up();
  return other;
}

NormalEquations::NormalEquations(Eigen::Index unknowns, int blocks, int folds)
    : unknowns_(unknowns), folds_(folds), blocks_(static_cast<std::size_t>(blocks), nothing(unknowns)) {
  sum_up();
}

NormalEquations::Part NormalEquations::nothing(Eigen::Index unknowns) {
  return {Eigen::MatrixXd::Zero(unknowns, unknowns), Eigen::VectorXd::Zero(unknowns), 0.0, 0.0};
}

void NormalEquations::add(const NormalEquations& rows, int block) {
  for (const Part& part : rows.blocks_) blocks_[static_cast<std::size_t>(block++)].add(part, 1.0);
}

void NormalEquations::add(const std::vector<double>& numbers, int block) {
  const double* next = numbers.data();
  Part part = nothing(unknowns_);
  part.gram = Eigen::Map<const Eigen::MatrixXd>(next, unknowns_, unknowns_);
  next += unknowns_ * unknowns_;
  part.right = Eigen::Map<const Eigen::VectorXd>(next, unknowns_);
  next += unknowns_;
  part.target_squared = next[0];
  part.weight = next[1];
  blocks_[static_cast<std::size_t>(block)].add(part, 1.0);
}

std::vector<double> NormalEquations::numbers_of(int block) const {
  const Part& part = blocks_[static_cast<std::size_t>(block)];
  std::vector<double> numbers(part.gram.data(), part.gram.data() + part.gram.size());
  numbers.insert(numbers.end(), part.right.data(), part.right.data() + part.right.size());
  numbers.push_back(part.target_squared);
  numbers.push_back(part.weight);
  return numbers;
}

void NormalEquations::sum_up() {
  total_ = nothing(unknowns_);
  for (const Part& block : blocks_) total_.add(block, 1.0);
}

double NormalEquations::squared_error(const Eigen::VectorXd& value, int block) const {
  return blocks_[static_cast<std::size_t>(block)].squared_error(value);
}

double NormalEquations::squared_error(const Eigen::VectorXd& value) const {
  return total_.squared_error(value);
}

BoundedSolution NormalEquations::fit(const Constraints& constraints,
                                     const std::vector<BoundState>& start) const {
  return solve_bounded({total_.gram + constraints.penalty, total_.right, constraints.lower, constraints.upper,
                        constraints.each_way},
                       start);
}

NormalEquations::CrossValidation NormalEquations::cross_validate(const Constraints& constraints,
                                                                 const std::vector<BoundState>& start) const {
  CrossValidation result;
  result.block_squared_error.assign(blocks_.size(), 0.0);
  double sum = 0.0;
  for (int fold = 0; fold < folds_; ++fold) {
    Part training = total_;
    for (int b = 0; b < block_count(); ++b) {
      if (b % folds_ == fold) training.add(blocks_[static_cast<std::size_t>(b)], -1.0);
    }
    const BoundedSolution solution =
        solve_bounded({training.gram + constraints.penalty, training.right, constraints.lower,
                       constraints.upper, constraints.each_way},
                      start);
    for (int b = 0; b < block_count(); ++b) {
      if (b % folds_ != fold) continue;
      const double error = squared_error(solution.value, b);
      result.block_squared_error[static_cast<std::size_t>(b)] = error;
      sum += error;
    }
  }
  result.rmse = std::sqrt(sum / weight());
  return result;
}

Eigen::VectorXd NormalEquations::standard_errors(const BoundedSolution& solution,
                                                 const Constraints& constraints) const {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < unknowns_; ++i) {
    if (solution.bound_states[static_cast<std::size_t>(i)] == BoundState::free) free.push_back(i);
  }
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(unknowns_);
  if (free.empty()) return errors;
  const std::vector<Eigen::Index> reported = free;
  BoundedProblem problem{
      total_.gram + constraints.penalty, {}, constraints.lower, constraints.upper, constraints.each_way};
  const Influence influence(problem.gram, constraints.each_way, std::move(free));
  std::vector<Eigen::VectorXd> scores;
  scores.reserve(blocks_.size());
  Eigen::VectorXd known = Eigen::VectorXd::Zero(unknowns_);
  Eigen::VectorXd known_squared = Eigen::VectorXd::Zero(unknowns_);
  for (const Part& block : blocks_) {
    scores.push_back(influence.score_of_noise(block.gram, block.right - block.gram * solution.value));
    const Eigen::VectorXd share = influence.information(block.gram);
    known += share;
    known_squared += share.cwiseAbs2();
  }
  const Eigen::VectorXd middle = problem.gram * solution.value;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(unknowns_);
  std::mt19937_64 random(kSeed);
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::VectorXd noise = Eigen::VectorXd::Zero(unknowns_);
    for (const Eigen::VectorXd& score : scores) noise += (random() >> 63U) != 0U ? score : -score;
    undo_sum_and_difference(constraints.each_way, noise);
    problem.right = middle + noise;
    squares += (solve_bounded(problem, solution.bound_states).value - solution.value).cwiseAbs2();
  }
  for (const Eigen::Index i : reported) {
    // Blocks that tell of this unknown, less the one that its value costs.
    const double freedom = squared(known(i)) / std::max(known_squared(i), 1e-300) - 1.0;
    errors(i) = std::sqrt(squares(i) / kDraws) * wider_for(freedom);
  }
  return errors;
}

}  // namespace slipstack::workbench
