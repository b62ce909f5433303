// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "sim_host/rng.h"
#include "workbench/papers/analysis/nonnegative_least_squares.h"

namespace slipstack::workbench {
namespace {

Eigen::MatrixXd random_matrix(sim::Rng& rng, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return rng.normal(); });
}

// The optimum of a convex problem is where the conditions of Karush, Kuhn and Tucker hold, whoever found it.
TEST(NonnegativeLeastSquares, MeetsTheOptimalityConditions) {
  sim::Rng rng(1);
  for (int trial = 0; trial < 300; ++trial) {
    const auto rows = static_cast<Eigen::Index>(5 + rng.below(60));
    const auto count = static_cast<Eigen::Index>(1 + rng.below(20));
    Eigen::MatrixXd columns = random_matrix(rng, rows, count);
    columns.array() += rng.uniform(0.0, 3.0);  // nearly alike
    const Eigen::VectorXd target = random_matrix(rng, rows, 1);
    std::vector<bool> free(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < free.size(); ++i) free[i] = rng.chance(0.2);
    const NonnegativeFit fit = nonnegative_least_squares(columns, target, free);
    const Eigen::VectorXd slope = columns.transpose() * (target - columns * fit.gains);
    for (Eigen::Index i = 0; i < count; ++i) {
      const double size = columns.col(i).norm() * target.norm();
      if (free[static_cast<std::size_t>(i)]) {
        EXPECT_NEAR(slope[i], 0.0, 1e-9 * size);
        continue;
      }
      EXPECT_GE(fit.gains[i], 0.0);
      EXPECT_LE(slope[i], 1e-9 * size);
      if (fit.gains[i] > 0.0) {
        EXPECT_NEAR(slope[i], 0.0, 1e-9 * size);
      }
    }
    EXPECT_NEAR(fit.residual_norm, (target - columns * fit.gains).norm(), 1e-9 * target.norm());
  }
}

TEST(NonnegativeLeastSquares, FindsPositiveGainsExactly) {
  sim::Rng rng(2);
  const Eigen::MatrixXd columns = random_matrix(rng, 50, 8);
  const Eigen::VectorXd truth = random_matrix(rng, 8, 1).cwiseAbs();
  const NonnegativeFit fit = nonnegative_least_squares(columns, columns * truth);
  EXPECT_LT((fit.gains - truth).norm(), 1e-10);
}

TEST(NonnegativeLeastSquares, LeavesColumnsOfZerosAlone) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(4, 2);
  columns.col(1).setOnes();
  const NonnegativeFit fit = nonnegative_least_squares(columns, Eigen::VectorXd::Constant(4, 3.0));
  EXPECT_EQ(fit.gains[0], 0.0);
  EXPECT_NEAR(fit.gains[1], 3.0, 1e-12);
}

TEST(NonnegativeLeastSquares, RefusesSizesThatDiffer) {
  EXPECT_THROW(nonnegative_least_squares(Eigen::MatrixXd::Zero(3, 2), Eigen::VectorXd::Zero(4)),
               std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::workbench
