// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The noise of a measurement's rows, and how they are weighted by it. It depends on the log alone, so every
/// model is judged by the same.
struct RowWeighing {
  Terms plain;                        ///< a model of mass and hysteresis only
  std::vector<double> force_noise_N;  ///< of the force of each log, white, before the filter
  double least = 0.0;                 ///< variance of the best row [N^2]
  double enough = 0.0;                ///< a variance above `least` that halves a row's weight [N^2]
  Eigen::VectorXd weights(const Eigen::VectorXd& variance) const;  ///< of rows of these variances [N^2]
  /// Weights the rows of a chunk of the same logs alike.
  void apply(Measurement& chunk) const;
};

/// Estimates the noise of the rows of a measurement (noise_floor.h) and weights them by it. Sets the noise
/// floor (Measurement::noise_floor_N()), and places the slip distances (slip_grid.h). Cost: three fits of
/// mass and hysteresis, two searches of shapes, fourteen evaluations of a model.
RowWeighing weigh_rows(Measurement& measurement);

}  // namespace slipstack::workbench
