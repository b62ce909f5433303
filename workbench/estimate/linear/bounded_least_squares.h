// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// Pairs (a, b) of unknowns whose sum and difference may not be negative: b_a >= |b_b|, what a coefficient is
/// on either side. An upper bound of a then holds for both.
using EachWay = std::vector<std::pair<Eigen::Index, Eigen::Index>>;

/// v_a, v_b -> (v_a + v_b) / 2, (v_a - v_b) / 2 for each pair: from sum and difference to the unknowns, and
/// what this makes of a gradient.
void turn(const EachWay& pairs, Eigen::VectorXd& vector);
/// The same for both sides of a symmetric matrix.
void turn(const EachWay& pairs, Eigen::MatrixXd& matrix);

/// min 1/2 b' G b - c' b  subject to lower <= b <= upper: least squares by its normal equations.
struct BoundedProblem {
  Eigen::MatrixXd gram;   ///< G, symmetric, positive semi-definite
  Eigen::VectorXd right;  ///< c
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
  EachWay each_way = {};
};

/// Which bound each unknown rests on, of a pair each_way its sum and its difference; kept between solves of
/// similar problems it saves most of the work.
enum class BoundState : std::int8_t { on_lower = -1, free = 0, on_upper = 1 };

struct BoundedSolution {
  Eigen::VectorXd value;
  std::vector<BoundState> bound_states;
  int iterations = 0;
};

/// The global minimum by the primal active-set method (Lawson & Hanson 1974 ch. 23; Stark & Parker 1995).
/// Columns are scaled to unit norm and a relative ridge of 1e-11 makes the minimum unique. `start` may hold
/// the rests of an earlier solve. Cost: a Cholesky factorisation of the free part for each change of the set.
BoundedSolution solve_bounded(const BoundedProblem& problem, const std::vector<BoundState>& start = {});

}  // namespace slipstack::workbench
