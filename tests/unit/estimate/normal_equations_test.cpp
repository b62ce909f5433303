// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/base/linear_systems.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Draw;

NormalEquations::Constraints wide(Index unknowns) {
  return {VectorXd::Constant(unknowns, -1e12), VectorXd::Constant(unknowns, 1e12),
          MatrixXd::Zero(unknowns, unknowns)};
}

/// A measurement with weights of its rows over two decades.
Measurement weighted_measurement(std::uint64_t seed) {
  Measurement measurement(test::wandering_log(seed, 1000.0, 12'000));
  Draw draw(seed + 1);
  VectorXd weights(measurement.row_count());
  for (Index row = 0; row < weights.size(); ++row) weights(row) = draw.log_uniform(0.01, 1.0);
  measurement.set_row_weights(weights);
  return measurement;
}

/// Rows of the chosen blocks, each times the root of its weight.
struct Rows {
  MatrixXd columns;
  VectorXd target;
};
template <class Choose>
Rows rows_where(const Measurement& measurement, const MatrixXd& columns, const VectorXd& target,
                Choose choose) {
  std::vector<Index> rows;
  for (Index row = 0; row < columns.rows(); ++row) {
    if (choose(measurement.row_blocks()[static_cast<std::size_t>(row)])) rows.push_back(row);
  }
  const VectorXd root = measurement.row_weights()(rows).cwiseSqrt();
  return {root.asDiagonal() * columns(rows, Eigen::all), root.cwiseProduct(target(rows))};
}

// Where an interval of a log is cut out by repairs, a block may have no rows. (As many columns as the program
// has: Eigen multiplies small matrices by another code path.)
TEST(NormalEquations, BlocksWithoutRowsAddNothing) {
  const Measurement measurement = weighted_measurement(8);
  Draw draw(9);
  const Index n = 60;
  const MatrixXd columns = draw.matrix(measurement.row_count(), n);
  const VectorXd target = draw.matrix(measurement.row_count(), 1);
  const NormalEquations whole(measurement, columns, target);
  const int parts = static_cast<int>(3 * measurement.row_count()) / measurement.block_count();
  const NormalEquations parted(measurement, columns, target, parts);
  int empty = 0;
  for (int block = 0; block < parted.block_count(); ++block) empty += parted.weight(block) == 0.0 ? 1 : 0;
  EXPECT_GT(empty, parted.block_count() / 2);
  EXPECT_NEAR((parted.gram() - whole.gram()).norm(), 0.0, 1e-10 * whole.gram().norm());
  EXPECT_NEAR((parted.right() - whole.right()).norm(), 0.0, 1e-10 * whole.right().norm());
}

TEST(NormalEquations, CrossValidationIsThatOfDirectFits) {
  const Measurement measurement = weighted_measurement(1);
  Draw draw(2);
  const Index n = 7;
  MatrixXd columns = draw.matrix(measurement.row_count(), n);
  columns.col(3) += 2.0 * columns.col(2);
  const VectorXd target = columns * draw.matrix(n, 1) + 0.1 * draw.matrix(measurement.row_count(), 1);
  columns.col(5) *= 1e6;  // kilograms beside newtons per metre
  const NormalEquations equations(measurement, columns, target);
  const auto is = equations.cross_validate(wide(n), {});

  double sum = 0.0;
  for (int fold = 0; fold < measurement.fold_count(); ++fold) {
    const Rows training = rows_where(measurement, columns, target,
                                     [&](int block) { return measurement.fold_of_block(block) != fold; });
    const VectorXd fit = solve_least_squares(training.columns, training.target);
    for (int b = 0; b < measurement.block_count(); ++b) {
      if (measurement.fold_of_block(b) != fold) continue;
      const Rows held_out = rows_where(measurement, columns, target, [&](int block) { return block == b; });
      const double error = (held_out.target - held_out.columns * fit).squaredNorm();
      EXPECT_NEAR(is.block_squared_error[static_cast<std::size_t>(b)], error, 1e-8 * error) << b;
      sum += error;
    }
  }
  EXPECT_NEAR(is.rmse, std::sqrt(sum / measurement.row_weights().sum()), 1e-9 * is.rmse);
  EXPECT_NEAR(equations.weight(), measurement.row_weights().sum(), 1e-9);
}

// Folds cover every row once, and blocks are not divided, since the noise of neighbouring rows is correlated.
TEST(NormalEquations, BlocksAreContiguousAndOfEqualLength) {
  const Measurement measurement(test::wandering_log(3, 1000.0, 12'000));
  const std::vector<int>& blocks = measurement.row_blocks();
  ASSERT_EQ(static_cast<Index>(blocks.size()), measurement.row_count());
  std::vector<int> length(static_cast<std::size_t>(measurement.block_count()), 0);
  for (std::size_t row = 0; row < blocks.size(); ++row) {
    if (row > 0) {
      EXPECT_TRUE(blocks[row] == blocks[row - 1] || blocks[row] == blocks[row - 1] + 1);
    }
    ++length[static_cast<std::size_t>(blocks[row])];
  }
  EXPECT_EQ(blocks.front(), 0);
  EXPECT_EQ(blocks.back(), measurement.block_count() - 1);
  const auto [shortest, longest] = std::minmax_element(length.begin(), length.end());
  EXPECT_LE(*longest - *shortest, 1);
  std::vector<int> per_fold(static_cast<std::size_t>(measurement.fold_count()), 0);
  for (int b = 0; b < measurement.block_count(); ++b)
    ++per_fold[static_cast<std::size_t>(measurement.fold_of_block(b))];
  for (const int count : per_fold) EXPECT_EQ(count, measurement.block_count() / measurement.fold_count());
}

void expect_same(const NormalEquations& a, const NormalEquations& b) {
  ASSERT_EQ(a.unknowns(), b.unknowns());
  EXPECT_LT((a.gram() - b.gram()).norm(), 1e-13 * b.gram().norm());
  EXPECT_LT((a.right() - b.right()).norm(), 1e-13 * b.right().norm());
  Draw draw(4);
  const VectorXd value = draw.matrix(a.unknowns(), 1);
  EXPECT_NEAR(a.squared_error(value), b.squared_error(value), 1e-11 * b.squared_error(value));
  for (int block = 0; block < a.block_count(); ++block) {
    EXPECT_NEAR(a.squared_error(value, block), b.squared_error(value, block),
                1e-11 * b.squared_error(value, block));
  }
  EXPECT_NEAR(a.weight(), b.weight(), 1e-12 * b.weight());
}

TEST(NormalEquations, AddingColumnsEqualsBuildingAnew) {
  const Measurement measurement = weighted_measurement(5);
  Draw draw(6);
  const MatrixXd columns = draw.matrix(measurement.row_count(), 5);
  const MatrixXd further = draw.matrix(measurement.row_count(), 3);
  const VectorXd target = draw.matrix(measurement.row_count(), 1);
  MatrixXd all(measurement.row_count(), 8);
  all << columns, further;
  const NormalEquations narrow(measurement, columns, target);
  expect_same(narrow.with(measurement, columns, further, target), NormalEquations(measurement, all, target));
  // And without the blocks.
  const NormalEquations sum = narrow.sum_with(measurement, columns, further, target);
  expect_same(sum, NormalEquations(measurement, all, target));
  const VectorXd other = draw.matrix(measurement.row_count(), 1);
  const NormalEquations moved = narrow.sum_with_target(measurement, columns, other);
  expect_same(moved, NormalEquations(measurement, columns, other));
  const double error = NormalEquations(measurement, columns, other).training_error(wide(5), {});
  EXPECT_NEAR(moved.training_error(wide(5), {}), error, 1e-10 * error);
}

TEST(NormalEquations, ReplacingTheTargetEqualsBuildingAnew) {
  const Measurement measurement = weighted_measurement(7);
  Draw draw(8);
  const MatrixXd columns = draw.matrix(measurement.row_count(), 5);
  const VectorXd first = draw.matrix(measurement.row_count(), 1);
  const VectorXd second = draw.matrix(measurement.row_count(), 1);
  expect_same(NormalEquations(measurement, columns, first).with_target(measurement, columns, second),
              NormalEquations(measurement, columns, second));
}

TEST(NormalEquations, SquaredErrorsAreThoseOfTheRows) {
  const Measurement measurement = weighted_measurement(9);
  Draw draw(10);
  const MatrixXd columns = draw.matrix(measurement.row_count(), 4);
  const VectorXd target = draw.matrix(measurement.row_count(), 1);
  const VectorXd value = draw.matrix(4, 1);
  const NormalEquations equations(measurement, columns, target);
  const Rows all = rows_where(measurement, columns, target, [](int) { return true; });
  const double should = (all.target - all.columns * value).squaredNorm();
  EXPECT_NEAR(equations.squared_error(value), should, 1e-12 * should);
  double sum = 0.0;
  for (int block = 0; block < equations.block_count(); ++block) sum += equations.squared_error(value, block);
  EXPECT_NEAR(sum, should, 1e-12 * should);
}

// The penalty is a ridge: rows sqrt(penalty) b = 0 added to the data.
TEST(NormalEquations, PenaltyIsARowOfItsOwn) {
  const Measurement measurement(test::wandering_log(11, 1000.0, 6000));
  Draw draw(12);
  const Index n = 4;
  const MatrixXd columns = draw.matrix(measurement.row_count(), n);
  const VectorXd target = draw.matrix(measurement.row_count(), 1);
  NormalEquations::Constraints constraints = wide(n);
  constraints.penalty.diagonal() << 0.0, 100.0, 1e4, 1e8;
  const VectorXd is = NormalEquations(measurement, columns, target).fit(constraints).value;
  MatrixXd more(columns.rows() + n, n);
  more << columns, MatrixXd(constraints.penalty.cwiseSqrt());
  VectorXd wanted(target.size() + n);
  wanted << target, VectorXd::Zero(n);
  const VectorXd should = solve_least_squares(more, wanted);
  EXPECT_LT((is - should).norm(), 1e-8 * should.norm());
}

// Eigen sums in an order that depends on them.
TEST(LinearSystems, CachesAreOfOneSizeOnEveryMachine) {
  EXPECT_EQ(Eigen::l1CacheSize(), 32 << 10);
  EXPECT_EQ(Eigen::l2CacheSize(), 256 << 10);
  EXPECT_EQ(Eigen::l3CacheSize(), 2 << 20);
}

}  // namespace
}  // namespace slipstack::workbench
