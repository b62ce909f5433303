// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The same motion as encoders of equal resolution would read it whose grids are shifted, each by another
/// part of a step.
std::vector<Measurement> encoder_realisations(const Measurement& measurement);

/// What no model can explain at the rows: the noise of the force through the filter, from the differences of
/// the force within what the model leaves bounds it by (residual_noise(), unless the noise was given); the
/// encoder's quantisation through mass times acceleration; and what quantisation does to the
/// hysteresis, which is not white where the axis is slow, so it is tried out: the motion is read again by
/// encoders whose grid is shifted, which believe that the axis went about otherwise where no reading tells,
/// and the model evaluated on each; what they err by is taken as far as the residual bears it out.
class NoiseFloor {
 public:
  explicit NoiseFloor(const Measurement& measurement);

  /// Weighted standard deviation [N]. Cost: seven evaluations of the model over the log.
  double of(const Terms& terms) const;
  /// The same for each log of the measurement.
  std::vector<double> of_each_log(const Terms& terms) const;
  /// Its variance at each row [N^2].
  Eigen::VectorXd variance(const Terms& terms) const;

 private:
  const Measurement& measurement_;
  std::vector<Measurement> realisations_;
};

/// Weighs the rows of a measurement by what quantisation leaves of their worth, judged with a plain model of
/// mass and hysteresis: the weights depend on the log alone, so errors of different models compare.
/// The weighing comes back, for pieces of the same logs.
struct RowWeighing {
  Terms plain;          ///< the plain model
  double least = 0.0;   ///< variance of the best row [N^2]
  double enough = 0.0;  ///< a variance above `least` that halves a row's weight [N^2]
  Eigen::VectorXd weights(const Eigen::VectorXd& variance) const;  ///< of rows of these variances [N^2]
  void apply(Measurement& piece) const;
};
RowWeighing weigh_rows(Measurement& measurement);

}  // namespace slipstack::workbench
