// SPDX-License-Identifier: Apache-2.0
// Products of tall matrices against those of Eigen.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/linear/tall_product.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Row counts around the tiles and vectors of the implementation, column counts around those added at once.
TEST(TallProduct, CombinationIsMatrixTimesFactors) {
  test::Draw draw(1);
  for (const Index rows : {0, 1, 3, 4, 1023, 1024, 1031, 5000}) {
    for (const Index columns : {0, 1, 7, 8, 9, 35}) {
      const MatrixXd wide = draw.matrix(rows + 2, columns + 1);
      const auto matrix = wide.block(1, 1, rows, columns);  // neither aligned nor without gaps
      VectorXd factors = draw.matrix(columns, 1);
      const VectorXd is = tall_combination(matrix, factors);
      ASSERT_EQ(is.size(), rows);
      if (rows == 0) continue;
      EXPECT_LT((is - matrix * factors).cwiseAbs().maxCoeff(), 1e-13 * (1.0 + static_cast<double>(columns)))
          << rows << " x " << columns;
    }
  }
}

// Columns whose factor is zero are not read.
TEST(TallProduct, CombinationLeavesOutColumnsWithoutFactor) {
  test::Draw draw(2);
  MatrixXd matrix = draw.matrix(100, 12);
  VectorXd factors = draw.matrix(12, 1);
  for (const Index column : {0, 5, 11}) {
    matrix.col(column).setConstant(std::nan(""));
    factors(column) = 0.0;
  }
  const VectorXd is = tall_combination(matrix, factors);
  for (const Index column : {0, 5, 11}) matrix.col(column).setZero();
  EXPECT_LT((is - matrix * factors).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(TallProduct, IsLeftTransposedTimesRight) {
  test::Draw draw(3);
  for (const Index rows : {1, 5, 1030}) {
    const MatrixXd left = draw.matrix(rows, 9);
    const MatrixXd right = draw.matrix(rows, 3);
    EXPECT_LT((tall_product(left, right) - left.transpose() * right).cwiseAbs().maxCoeff(), 1e-11);
    const VectorXd weights = draw.matrix(rows, 1).cwiseAbs();
    EXPECT_LT(
        (weighted_gram(left, weights) - left.transpose() * weights.asDiagonal() * left).cwiseAbs().maxCoeff(),
        1e-11);
  }
}

}  // namespace
}  // namespace slipstack::workbench
