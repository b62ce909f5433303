// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace slipstack::workbench {

/// min 1/2 b' G b - c' b  subject to lower <= b <= upper: least squares by its normal equations.
struct BoundedProblem {
  Eigen::MatrixXd gram;   ///< G, symmetric, positive semi-definite
  Eigen::VectorXd right;  ///< c
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
};

/// Which bound each unknown rests on; kept between solves of similar problems it saves most of the work.
enum class Rests : std::int8_t { on_lower = -1, free = 0, on_upper = 1 };

struct BoundedSolution {
  Eigen::VectorXd value;
  std::vector<Rests> rests;
  int iterations = 0;
};

/// The global minimum by the primal active-set method (Lawson & Hanson 1974 ch. 23; Stark & Parker 1995).
/// Columns are scaled to unit norm and a relative ridge of 1e-11 makes the minimum unique. `start` may hold
/// the rests of an earlier solve. Cost: a Cholesky factorisation of the free part for each change of the set.
BoundedSolution solve_bounded(const BoundedProblem& problem, const std::vector<Rests>& start = {});

}  // namespace slipstack::workbench
