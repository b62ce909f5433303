// SPDX-License-Identifier: Apache-2.0
// Bounded least squares against every possible set of active bounds, and against the conditions of
// optimality.
#include "workbench/estimate/linear/bounded_least_squares.h"
#include "workbench/base/linear_systems.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double objective(const BoundedProblem& p, const VectorXd& b) {
  return 0.5 * b.dot(p.gram * b) - p.right.dot(b);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double normal() { return normal_(engine_); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  std::size_t below(std::size_t count) { return engine_() % count; }
  MatrixXd matrix(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [this] { return normal(); });
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

/// Bounds of every kind: around zero, to one side of it, wide, and without room.
void draw_bounds(Random& random, Index n, BoundedProblem& p) {
  p.lower.resize(n);
  p.upper.resize(n);
  for (Index i = 0; i < n; ++i) {
    const double width = random.uniform(0.1, 2.0);
    switch (random.below(6)) {
      case 0:
        p.lower(i) = 0.0, p.upper(i) = 1e12;
        break;
      case 1:
        p.lower(i) = -width, p.upper(i) = width;
        break;
      case 2:
        p.lower(i) = 0.2 * width, p.upper(i) = width;
        break;
      case 3:
        p.lower(i) = -2.0 * width, p.upper(i) = -width;
        break;
      case 4:
        p.lower(i) = p.upper(i) = random.normal();
        break;
      default:
        p.lower(i) = -1e12, p.upper(i) = 1e12;
        break;
    }
  }
}

/// Least squares from rows, with columns of very different size, as mass and stiffness are.
BoundedProblem random_problem(Random& random, Index n, Index rows, double mix) {
  MatrixXd columns = random.matrix(rows, n);
  for (Index i = 1; i < n; ++i) columns.col(i) += mix * columns.col(i - 1);
  BoundedProblem p;
  const VectorXd target = columns * (random.matrix(n, 1) * 1.5) + random.matrix(rows, 1);
  draw_bounds(random, n, p);
  for (Index i = 0; i < n; ++i) {
    const double unit = std::pow(10.0, random.uniform(-4.0, 4.0));
    columns.col(i) *= unit;
    p.lower(i) /= unit;
    p.upper(i) /= unit;
  }
  p.gram = columns.transpose() * columns;
  p.right = columns.transpose() * target;
  return p;
}

/// The minimum by exhaustive search over all 3^n sets of bound states.
double best_of_all_sets(const BoundedProblem& p) {
  const Index n = p.right.size();
  const VectorXd unit = p.gram.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd gram = unit.asDiagonal() * p.gram * unit.asDiagonal();
  const VectorXd right = unit.cwiseProduct(p.right);
  const VectorXd lower = p.lower.cwiseQuotient(unit);
  const VectorXd upper = p.upper.cwiseQuotient(unit);
  const auto sets = static_cast<int>(std::lround(std::pow(3.0, static_cast<double>(n))));
  double best = std::numeric_limits<double>::infinity();
  for (int set = 0; set < sets; ++set) {
    VectorXd b = VectorXd::Zero(n);
    std::vector<Index> free;
    int digits = set;
    for (Index i = 0; i < n; ++i, digits /= 3) {
      if (digits % 3 == 0) free.push_back(i);
      if (digits % 3 == 1) b(i) = lower(i);
      if (digits % 3 == 2) b(i) = upper(i);
    }
    if (!free.empty()) {
      const VectorXd rest = right - gram * b;
      b(free) = VectorXd(MatrixXd(gram(free, free)).fullPivHouseholderQr().solve(VectorXd(rest(free))));
    }
    const bool inside = (b.array() >= lower.array() - 1e-9 * (1.0 + lower.array().abs())).all() &&
                        (b.array() <= upper.array() + 1e-9 * (1.0 + upper.array().abs())).all();
    if (inside) best = std::min(best, 0.5 * b.dot(gram * b) - right.dot(b));
  }
  return best;
}

/// Largest violation of the conditions of Karush, Kuhn and Tucker, relative to the largest scaled gradient.
double violation(const BoundedProblem& p, const VectorXd& b) {
  const VectorXd pull = p.right - p.gram * b;
  double worst = 0.0;
  double unit = 1e-300;
  for (Index i = 0; i < b.size(); ++i) {
    const double scale = p.gram(i, i) > 0.0 ? 1.0 / std::sqrt(p.gram(i, i)) : 1.0;
    unit = std::max(unit, std::abs(p.right(i)) * scale);
    const bool may_fall = b(i) > p.lower(i);
    const bool may_rise = b(i) < p.upper(i);
    if (may_rise) worst = std::max(worst, pull(i) * scale);
    if (may_fall) worst = std::max(worst, -pull(i) * scale);
  }
  return worst / unit;
}

void expect_inside(const BoundedProblem& p, const VectorXd& b) {
  for (Index i = 0; i < b.size(); ++i) {
    EXPECT_GE(b(i), p.lower(i));
    EXPECT_LE(b(i), p.upper(i));
  }
}

void expect_rests_told_rightly(const BoundedProblem& p, const BoundedSolution& solution) {
  for (Index i = 0; i < solution.value.size(); ++i) {
    const BoundState bound_states = solution.bound_states[static_cast<std::size_t>(i)];
    if (bound_states == BoundState::on_lower) {
      EXPECT_EQ(solution.value(i), p.lower(i));
    }
    if (bound_states == BoundState::on_upper) {
      EXPECT_EQ(solution.value(i), p.upper(i));
    }
  }
}

TEST(BoundedLeastSquares, FindsTheBestOfAllSets) {
  int at_bounds = 0;
  int unknowns = 0;
  for (std::uint64_t seed = 0; seed < 250; ++seed) {
    Random random(seed);
    const auto n = static_cast<Index>(1 + random.below(6));
    const BoundedProblem p = random_problem(random, n, n + 5, seed % 3 == 0 ? 3.0 : 0.3);
    const BoundedSolution solution = solve_bounded(p);
    expect_inside(p, solution.value);
    expect_rests_told_rightly(p, solution);
    const double best = best_of_all_sets(p);
    EXPECT_NEAR(objective(p, solution.value), best, 1e-8 * (1.0 + std::abs(best))) << seed;
    for (const BoundState bound_states : solution.bound_states)
      at_bounds += bound_states == BoundState::free ? 0 : 1;
    unknowns += static_cast<int>(n);
  }
  EXPECT_GT(at_bounds, unknowns / 4);  // otherwise the bounds were hardly tested
  EXPECT_LT(at_bounds, 3 * unknowns / 4);
}

TEST(BoundedLeastSquares, FindsTheBestOfAllSetsOfSeven) {
  for (std::uint64_t seed = 1000; seed < 1006; ++seed) {
    Random random(seed);
    const BoundedProblem p = random_problem(random, 7, 30, 1.0);
    const double best = best_of_all_sets(p);
    EXPECT_NEAR(objective(p, solve_bounded(p).value), best, 1e-8 * (1.0 + std::abs(best))) << seed;
  }
}

/// Columns as hysteresis has them: stop operators of neighbouring slip distances along a random walk.
MatrixXd stop_operator_columns(Random& random, Index rows, Index n) {
  MatrixXd columns(rows, n);
  VectorXd stretch = VectorXd::Zero(n);
  double speed = 0.0;
  for (Index row = 0; row < rows; ++row) {
    if (row % 40 == 0) speed = random.normal() * std::pow(10.0, random.uniform(-2.0, 0.5));
    for (Index i = 0; i < n; ++i) {
      const double slip = std::pow(10.0, -2.0 + 4.0 * static_cast<double>(i) / static_cast<double>(n));
      stretch(i) = std::clamp(stretch(i) + speed, -slip, slip);
    }
    columns.row(row) = stretch.transpose();
  }
  return columns;
}

BoundedProblem hysteresis_problem(Random& random, Index n) {
  const Index rows = 3000;
  const MatrixXd columns = stop_operator_columns(random, rows, n);
  VectorXd stiffness(n);
  for (Index i = 0; i < n; ++i) stiffness(i) = random.below(3) == 0 ? random.uniform(0.0, 2.0) : 0.0;
  const VectorXd target = columns * stiffness + 0.2 * random.matrix(rows, 1);
  BoundedProblem p;
  p.gram = columns.transpose() * columns;
  p.right = columns.transpose() * target;
  p.lower = VectorXd::Zero(n);
  p.upper = VectorXd::Constant(n, 1e12);
  return p;
}

TEST(BoundedLeastSquares, SatisfiesOptimalityWithSixtyStopOperators) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const BoundedProblem p = hysteresis_problem(random, 60);
    const BoundedSolution solution = solve_bounded(p);
    expect_inside(p, solution.value);
    EXPECT_LT(violation(p, solution.value), 1e-7) << seed;
    EXPECT_LT(solution.iterations, 400) << seed;
  }
}

TEST(BoundedLeastSquares, SatisfiesOptimalityWithSixtyUnknownsOfAllKinds) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const BoundedProblem p = random_problem(random, 60, 200, 2.0);
    const BoundedSolution solution = solve_bounded(p);
    expect_inside(p, solution.value);
    expect_rests_told_rightly(p, solution);
    EXPECT_LT(violation(p, solution.value), 1e-7) << seed;
  }
}

// The bound states of another problem save work and must not change the solution, however wrong they are.
TEST(BoundedLeastSquares, WarmStartGivesTheSameAnswer) {
  int saved = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Random random(seed);
    const BoundedProblem p =
        seed % 2 == 0 ? hysteresis_problem(random, 40) : random_problem(random, 40, 150, 2.0);
    const BoundedSolution cold = solve_bounded(p);
    BoundedProblem near = p;
    near.right *= 1.01;
    const BoundedSolution warm = solve_bounded(p, solve_bounded(near).bound_states);
    std::vector<BoundState> anything;
    for (Index i = 0; i < 40; ++i)
      anything.push_back(static_cast<BoundState>(static_cast<int>(random.below(3)) - 1));
    const BoundedSolution wild = solve_bounded(p, anything);
    const double scale = std::abs(objective(p, cold.value));
    EXPECT_NEAR(objective(p, warm.value), objective(p, cold.value), 1e-10 * scale) << seed;
    EXPECT_NEAR(objective(p, wild.value), objective(p, cold.value), 1e-10 * scale) << seed;
    expect_inside(p, warm.value);
    expect_inside(p, wild.value);
    EXPECT_LT(violation(p, wild.value), 1e-7) << seed;
    saved += cold.iterations - warm.iterations;
  }
  EXPECT_GT(saved, 30 * 5);
}

TEST(BoundedLeastSquares, SharesBetweenEqualColumns) {
  Random random(4);
  const MatrixXd one = random.matrix(50, 3);
  MatrixXd columns(50, 5);
  columns << one, one.col(0), one.col(1);
  const VectorXd target = one * Eigen::Vector3d(2.0, -1.0, 0.5) + 0.01 * random.matrix(50, 1);
  BoundedProblem p{columns.transpose() * columns, columns.transpose() * target, VectorXd::Constant(5, -10.0),
                   VectorXd::Constant(5, 10.0)};
  p.lower(1) = -0.25;  // one of two equal columns is limited by its bound
  const BoundedSolution solution = solve_bounded(p);
  const VectorXd plain = solve_least_squares(one, target);
  EXPECT_NEAR(solution.value(0) + solution.value(3), plain(0), 1e-5);
  EXPECT_NEAR(solution.value(1) + solution.value(4), plain(1), 1e-5);
  EXPECT_NEAR(solution.value(2), plain(2), 1e-5);
  expect_inside(p, solution.value);
  EXPECT_LT(violation(p, solution.value), 1e-7);
}

TEST(BoundedLeastSquares, LeavesAZeroColumnAtZero) {
  Random random(5);
  MatrixXd columns = random.matrix(30, 3);
  columns.col(1).setZero();
  const VectorXd target = random.matrix(30, 1);
  const BoundedProblem p{columns.transpose() * columns, columns.transpose() * target,
                         VectorXd::Constant(3, -5.0), VectorXd::Constant(3, 5.0)};
  const BoundedSolution solution = solve_bounded(p);
  EXPECT_EQ(solution.value(1), 0.0);
  EXPECT_LT(violation(p, solution.value), 1e-8);
}

// A given mass is preserved to the last bit, whatever the internal scaling.
TEST(BoundedLeastSquares, KeepsGivenValuesExactly) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    BoundedProblem p = random_problem(random, 4, 20, 0.5);
    p.lower(2) = p.upper(2) = random.uniform(0.1, 100.0);
    const BoundedSolution solution = solve_bounded(p);
    EXPECT_EQ(solution.value(2), p.lower(2));
    expect_inside(p, solution.value);
  }
}

TEST(BoundedLeastSquares, ReturnsGivenValuesWhereAllAreGiven) {
  Random random(6);
  BoundedProblem p = random_problem(random, 3, 20, 0.5);
  p.lower = p.upper = Eigen::Vector3d(1.0, -2.0, 0.0);
  EXPECT_EQ(solve_bounded(p).value, p.lower);
}

TEST(BoundedLeastSquares, NothingToFitIsZero) {
  BoundedProblem p{MatrixXd::Identity(3, 3), VectorXd::Zero(3), VectorXd::Constant(3, -1.0),
                   VectorXd::Constant(3, 1.0)};
  EXPECT_EQ(solve_bounded(p).value, VectorXd::Zero(3));
}

// A coefficient that may not be negative in either direction: a >= |b|. Against a grid search of the feasible
// set.
TEST(SumDifferencePairs, FindsTheMinimumWithinTheWedge) {
  int on_an_edge = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed + 900);
    const MatrixXd columns = random.matrix(30, 2);
    const VectorXd target = columns * (random.matrix(2, 1) * 1.5) + random.matrix(30, 1);
    BoundedProblem p{columns.transpose() * columns,
                     columns.transpose() * target,
                     VectorXd::Constant(2, -1e12),
                     VectorXd::Constant(2, 2.5),
                     {{0, 1}}};
    const VectorXd b = solve_bounded(p).value;
    ASSERT_GE(b(0), std::abs(b(1)) - 1e-12) << seed;
    ASSERT_LE(b(0) + std::abs(b(1)), 2.5 + 1e-12) << seed;
    if (b(0) - std::abs(b(1)) < 1e-9) ++on_an_edge;
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 250; ++i) {
      for (int k = 0; k <= 250; ++k) {
        const VectorXd at = VectorXd{{0.005 * (i + k), 0.005 * (i - k)}};
        best = std::min(best, objective(p, at));
      }
    }
    EXPECT_LE(objective(p, b), best + 1e-12) << seed;
    EXPECT_GE(objective(p, b), best - 0.01 * (1.0 + std::abs(best))) << seed;
  }
  EXPECT_GT(on_an_edge, 15);
  EXPECT_LT(on_an_edge, 55);
}

// Among other unknowns, and with a start from another problem, the answer is the same minimum.
TEST(SumDifferencePairs, OtherUnknownsAndAStartChangeNothing) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed + 1300);
    BoundedProblem p = random_problem(random, 6, 40, 0.5);
    p.lower(1) = p.lower(4) = -1e12;
    p.upper(1) = p.upper(4) = 1e12;
    // Both unknowns of a pair have the same unit.
    for (const Index i : {1, 4}) {
      const double unit = 1.0 / std::sqrt(p.gram(i, i));
      p.gram.row(i) *= unit;
      p.gram.col(i) *= unit;
      p.right(i) *= unit;
    }
    const BoundedProblem loose = p;
    p.pairs = {{4, 1}};
    const BoundedSolution cold = solve_bounded(p);
    const BoundedSolution warm = solve_bounded(p, solve_bounded(loose).bound_states);
    EXPECT_NEAR(objective(p, cold.value), objective(p, warm.value),
                1e-7 * (1.0 + std::abs(objective(p, cold.value))))
        << seed;
    EXPECT_GE(cold.value(4), std::abs(cold.value(1)) * (1.0 - 1e-12)) << seed;
    // Where the constraint is not active, it has no effect.
    const VectorXd free = solve_bounded(loose).value;
    if (free(4) > std::abs(free(1))) {
      EXPECT_LT((cold.value - free).norm(), 1e-6 * (1.0 + free.norm())) << seed;
    } else {
      EXPECT_GT(objective(p, cold.value), objective(p, free)) << seed;
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
