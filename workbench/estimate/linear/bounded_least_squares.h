// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Pairs (a, b) of unknowns constrained by b_a >= |b_b|, i.e. neither their sum nor their difference is
/// negative: the coefficients of the two directions of motion. The upper bound of a then holds for both.
using SumDifferencePairs = std::vector<std::pair<Eigen::Index, Eigen::Index>>;

/// The sum-difference transform T of each pair: (v_a, v_b) -> ((v_a + v_b) / 2, (v_a - v_b) / 2). It maps
/// sums and differences to the unknowns and, because T is symmetric, a gradient by the unknowns to one by
/// sums and differences.
void sum_difference_transform(const SumDifferencePairs& pairs, Eigen::VectorXd& vector);
/// T M T of a symmetric matrix M.
void sum_difference_transform(const SumDifferencePairs& pairs, Eigen::MatrixXd& matrix);
/// The inverse of T, on a vector.
void inverse_sum_difference_transform(const SumDifferencePairs& pairs, Eigen::VectorXd& vector);

/// min 1/2 b' G b - c' b  subject to lower <= b <= upper: least squares by its normal equations.
struct BoundedProblem {
  Eigen::MatrixXd gram;   ///< G, symmetric, positive semi-definite
  Eigen::VectorXd right;  ///< c
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
  SumDifferencePairs pairs = {};
};

/// At which bound each unknown is; of a pair, its sum and its difference. The states of a similar problem are
/// a start that saves most of the work.
enum class BoundState : std::int8_t { on_lower = -1, free = 0, on_upper = 1 };

struct BoundedSolution {
  Eigen::VectorXd value;
  std::vector<BoundState> bound_states;
  int iterations = 0;
};

/// The global minimum by the primal active-set method (Lawson & Hanson 1974 ch. 23; Stark & Parker 1995).
/// Columns are scaled to unit norm, and a relative ridge of 1e-11 makes the minimum unique. `start` may hold
/// the bound states of an earlier solution. Cost: a Cholesky factorisation of the free part for each change
/// of the active set.
BoundedSolution solve_bounded(const BoundedProblem& problem, const std::vector<BoundState>& start = {});

}  // namespace slipstack::workbench
