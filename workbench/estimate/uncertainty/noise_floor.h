// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The same motion as read by encoders of equal resolution with shifted grids, each by another fraction of a
/// step.
std::vector<Measurement> encoder_realisations(const Measurement& measurement);

/// The noise floor: the error at the rows that no model can explain. It has three parts.
/// - The noise of the force after the filter, estimated from the differences between samples, within the
/// bounds that
///   the residual sets (residual_noise()); or as given.
/// - The encoder's quantisation, through mass times acceleration.
/// - The effect of quantisation on the hysteresis. It is not white where the axis is slow, so it is
/// simulated: the
///   motion is read again by encoders with shifted grids and with other assumptions about the motion between
///   readings, and the model is evaluated on each. Their error counts as far as it is supported by the
///   residual.
class NoiseFloor {
 public:
  explicit NoiseFloor(const Measurement& measurement);

  /// Weighted standard deviation of the noise floor [N]. Cost: seven evaluations of the model over the log.
  double of(const Terms& terms) const;
  /// The same for each log of the measurement.
  std::vector<double> of_each_log(const Terms& terms) const;
  /// Variance of the noise floor at each row [N^2].
  Eigen::VectorXd variance(const Terms& terms) const;

 private:
  const Measurement& measurement_;
  std::vector<Measurement> realisations_;
};

/// How rows are weighted by their noise.
struct RowWeighing {
  Terms plain;          ///< a model of mass and hysteresis only
  double least = 0.0;   ///< variance of the best row [N^2]
  double enough = 0.0;  ///< a variance above `least` that halves a row's weight [N^2]
  Eigen::VectorXd weights(const Eigen::VectorXd& variance) const;  ///< of rows of these variances [N^2]
  /// Weights the rows of a chunk of the same logs alike.
  void apply(Measurement& chunk) const;
};
/// Weights the rows of a measurement by their noise, computed with a model of mass and hysteresis only. The
/// weights then depend on the log alone, so that errors of different models can be compared. Also places the
/// slip distances (slip_grid.h).
RowWeighing weigh_rows(Measurement& measurement);

}  // namespace slipstack::workbench
