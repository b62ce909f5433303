// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// Bounds of the white noise of the force before the filter [N], from the residual of a model.
struct NoiseBounds {
  double least_N = 0.0;
  double most_N = std::numeric_limits<double>::infinity();
  /// The estimate from the differences between samples, limited to these bounds.
  double bounded(double sensor_N) const;
};

/// The noise of the force of one log, from the residual of a model. The differences between samples alone
/// mislead in two ways. Random forces on the axis that no sensor measures (noise of the drive, rough rolling)
/// appear only in the residual, because the current of a controlled axis need not contain them. And what a
/// controller does from sample to sample is no noise, because it is measured and moves the axis.
///
/// The power of the residual is estimated in bands in the upper part of the rows' bandwidth, where friction
/// and motion contribute little, in segments of the log. The lower bound is the weakest band after
/// subtraction of the encoder's quantisation (through `mass_kg`, and through the hysteresis, as the mean
/// power of `realisations_N`), of the quarter of the segments with the least: what the model lacks only adds
/// to the noise, and in a motion that repeats it acts in most of them. The upper bound is the strongest band
/// after subtraction of the former only, by the median. No bounds for a log of fewer than 16 segments of 32
/// rows. `residual_N` and `realisations_N`: of all rows.
NoiseBounds residual_noise(const Measurement& measurement, const LogPart& part,
                           const Eigen::VectorXd& residual_N,
                           const std::vector<Eigen::VectorXd>& realisations_N, double mass_kg);

}  // namespace slipstack::workbench
