// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The same motion as read by encoders of equal resolution with shifted grids, each by another fraction of a
/// step.
std::vector<Measurement> encoder_realisations(const Measurement& measurement);

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

/// Estimates the noise of the rows of a measurement, and weights them by it. Sets the noise floor
/// (Measurement::noise_floor_N()), the error that no model can explain. It has three parts:
/// - the noise of the force after the filter: as given, or from the differences between samples, within the
///   bounds that the saturated residual sets (residual_noise.h, saturated_residual.h);
/// - the encoder's quantisation, through mass times acceleration;
/// - the effect of quantisation on the hysteresis. It is not white where the axis is slow, so it is
/// simulated:
///   the motion is read again by encoders with shifted grids and with other assumptions about the motion
///   between readings, and a model of mass and hysteresis is evaluated on each. Their error counts as far as
///   the saturated residual supports it.
/// Also places the slip distances (slip_grid.h). Cost: three fits of mass and hysteresis, two searches of
/// shapes, fourteen evaluations.
RowWeighing weigh_rows(Measurement& measurement);

}  // namespace slipstack::workbench
