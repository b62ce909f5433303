// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What of the force follows from the motion without a model of friction: inertia, viscous and Coulomb
/// friction, a spring that may stiffen and a constant. The declared mass times acceleration (or the
/// acceleration, where none is declared), v, sign(v), x, x^2, x^3, 1, at the samples and at the rows; x about
/// its mean, largest 1. In a motion to and fro what a straight spring leaves of a bent one is an inertia of
/// either sign. Cost: four signals through the common filter.
struct MotionTerms {
  enum : int { kInertia, kViscous, kCoulomb, kSpring, kSquare, kCube, kConstant };
  static constexpr int kCount = kConstant + 1;

  std::vector<double> inertia_N;  ///< by the declared mass of each log, where all logs declare one
  std::vector<double> direction;  ///< sign of the velocity
  Eigen::Matrix<double, Eigen::Dynamic, kCount> at_rows;

  explicit MotionTerms(const Measurement& measurement);
};

/// -1, 0 or 1 for each value.
std::vector<double> signs_of(const std::vector<double>& values);

}  // namespace slipstack::workbench
