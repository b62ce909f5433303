// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/normal_equations.h"

#include <algorithm>
#include <cmath>

#include "workbench/estimate/linear/tall_product.h"

namespace slipstack::workbench {
namespace {

/// At most so many parts per block: enough parts then contain what only few movements excite, and finer ones
/// give the same standard errors.
constexpr Eigen::Index kMostParts = 4;

}  // namespace

int parts_of_block(const Measurement& measurement) {
  const Eigen::Index rows = measurement.row_count() / std::max(1, measurement.block_count());
  return static_cast<int>(std::clamp<Eigen::Index>(rows / kLeastRowsOfPart, 1, kMostParts));
}

std::vector<RowRange> block_ranges(const Measurement& measurement, int parts) {
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
    : unknowns_(columns.cols()), folds_(measurement.fold_count()), parts_of_block_(parts_of_block) {
  for (const RowRange& range : block_ranges(measurement, parts_of_block)) {
    if (range.count == 0) {  // all rows cut out by repairs
      blocks_.push_back(nothing(unknowns_));
      continue;
    }
    const auto weights = measurement.fit_weights().segment(range.first, range.count);
    const auto part = columns.middleRows(range.first, range.count);
    const auto wanted = target.segment(range.first, range.count);
    const Eigen::VectorXd weighted_target = weights.cwiseProduct(wanted);
    Part block;
    block.gram = weighted_gram(part, weights);
    block.right = tall_product(part, weighted_target);
    block.target_squared = weighted_target.dot(wanted);
    block.weight = weights.sum();
    blocks_.push_back(std::move(block));
  }
  sum_up();
}

NormalEquations::Part NormalEquations::widened(const Part& part,
                                               const Eigen::Ref<const Eigen::VectorXd>& weights,
                                               const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                               const Eigen::Ref<const Eigen::MatrixXd>& further,
                                               const Eigen::Ref<const Eigen::VectorXd>& target) {
  const Eigen::Index old = columns.cols();
  const Eigen::Index added = further.cols();
  const Eigen::MatrixXd weighted_part = weights.asDiagonal() * further;
  Part wider{Eigen::MatrixXd(old + added, old + added), Eigen::VectorXd(old + added), part.target_squared,
             part.weight};
  wider.gram.topLeftCorner(old, old) = part.gram;
  wider.gram.topRightCorner(old, added) = tall_product(columns, weighted_part);
  wider.gram.bottomLeftCorner(added, old) = wider.gram.topRightCorner(old, added).transpose();
  wider.gram.bottomRightCorner(added, added) = tall_product(weighted_part, further);
  wider.right.head(old) = part.right;
  wider.right.tail(added) = tall_product(weighted_part, target);
  return wider;
}

NormalEquations NormalEquations::with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                      const Eigen::MatrixXd& further, const Eigen::VectorXd& target) const {
  NormalEquations wider;
  wider.unknowns_ = unknowns_ + further.cols();
  wider.folds_ = folds_;
  const std::vector<RowRange> ranges = block_ranges(measurement);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const auto [first, count] = ranges[b];
    wider.blocks_.push_back(widened(blocks_[b], measurement.fit_weights().segment(first, count),
                                    columns.middleRows(first, count), further.middleRows(first, count),
                                    target.segment(first, count)));
  }
  wider.sum_up();
  return wider;
}

NormalEquations NormalEquations::sum_with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                          const Eigen::MatrixXd& further,
                                          const Eigen::VectorXd& target) const {
  NormalEquations wider;
  wider.unknowns_ = unknowns_ + further.cols();
  wider.folds_ = folds_;
  wider.total_ = widened(total_, measurement.fit_weights(), columns, further, target);
  return wider;
}

NormalEquations NormalEquations::with_target(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                             const Eigen::VectorXd& target) const {
  NormalEquations other = *this;
  const std::vector<RowRange> ranges = block_ranges(measurement);
  const Eigen::VectorXd weighted_target = measurement.fit_weights().cwiseProduct(target);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const auto [first, count] = ranges[b];
    other.blocks_[b].right =
        tall_product(columns.middleRows(first, count), weighted_target.segment(first, count));
    other.blocks_[b].target_squared = weighted_target.segment(first, count).dot(target.segment(first, count));
  }
  other.sum_up();
  return other;
}

NormalEquations NormalEquations::sum_with_target(const Measurement& measurement,
                                                 const Eigen::MatrixXd& columns,
                                                 const Eigen::VectorXd& target) const {
  NormalEquations other;
  other.unknowns_ = unknowns_;
  other.folds_ = folds_;
  const Eigen::VectorXd weighted_target = measurement.fit_weights().cwiseProduct(target);
  other.total_ = {total_.gram, tall_product(columns, weighted_target), weighted_target.dot(target),
                  total_.weight};
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
                        constraints.pairs},
                       start);
}

BoundedSolution NormalEquations::fit_near(const Eigen::VectorXd& here, double damping,
                                          const Constraints& constraints,
                                          const std::vector<BoundState>& start) const {
  BoundedProblem problem{total_.gram + constraints.penalty, total_.right, constraints.lower,
                         constraints.upper, constraints.pairs};
  const Eigen::VectorXd damped = damping * problem.gram.diagonal();
  problem.gram.diagonal() += damped;
  problem.right += damped.cwiseProduct(here);
  return solve_bounded(problem, start);
}

double NormalEquations::training_error(const Constraints& constraints,
                                       const std::vector<BoundState>& start) const {
  const Eigen::VectorXd value = fit(constraints, start).value;
  return std::sqrt((squared_error(value) + value.dot(constraints.penalty * value)) / weight());
}

BoundedSolution NormalEquations::fit_without(const std::vector<bool>& held_out,
                                             const Constraints& constraints,
                                             const std::vector<BoundState>& start) const {
  Part training = total_;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (held_out[b]) training.add(blocks_[b], -1.0);
  }
  return solve_bounded({training.gram + constraints.penalty, training.right, constraints.lower,
                        constraints.upper, constraints.pairs},
                       start);
}

double NormalEquations::error_without(const std::vector<bool>& held_out, const Constraints& constraints,
                                      const std::vector<BoundState>& start) const {
  const BoundedSolution solution = fit_without(held_out, constraints, start);
  double squares = 0.0;
  double weight = 0.0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (!held_out[b]) continue;
    squares += blocks_[b].squared_error(solution.value);
    weight += blocks_[b].weight;
  }
  return weight > 0.0 ? std::sqrt(squares / weight) : 0.0;
}

NormalEquations::CrossValidation NormalEquations::cross_validate(const Constraints& constraints,
                                                                 const std::vector<BoundState>& start) const {
  CrossValidation result;
  result.block_squared_error.assign(blocks_.size(), 0.0);
  double sum = 0.0;
  for (int fold = 0; fold < folds_; ++fold) {
    std::vector<bool> held_out(blocks_.size());
    for (std::size_t b = 0; b < held_out.size(); ++b) held_out[b] = static_cast<int>(b) % folds_ == fold;
    const BoundedSolution solution = fit_without(held_out, constraints, start);
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

}  // namespace slipstack::workbench
