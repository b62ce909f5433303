// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"

namespace slipstack::workbench {

/// Variances at the rows [N^2].
struct RowVariances {
  Eigen::VectorXd noise;         ///< of force and acceleration
  Eigen::VectorXd quantisation;  ///< of the hysteresis force, by quantisation
};

/// Of rows where a model of this mass and hysteresis has these changes by quantisation. `force_noise_N`: of
/// each log, white, before the filter.
RowVariances variances_at_rows(const Measurement& measurement, const Terms& terms,
                               const std::vector<double>& force_noise_N, const ForceChanges& changes_N);

/// The noise of each log's force before the filter [N]: as given, or what the differences between samples
/// say, within the bounds that the saturated residual sets (residual_noise.h).
std::vector<double> force_noise_of_logs_N(const Measurement& measurement, const Terms& reference,
                                          const Eigen::VectorXd& saturated_N, const ForceChanges& changes_N);

/// The variance that no model can explain, at each row [N^2]; its weighted mean is the square of the noise
/// floor. It has three parts:
/// - the noise of the force after the filter;
/// - the encoder's quantisation, through mass times acceleration;
/// - the effect of quantisation on the hysteresis. It is not white where the axis is slow, so it is
///   simulated (encoder_realisations.h). It counts as far as the saturated residual supports it.
Eigen::VectorXd unexplainable_variance(const RowVariances& rows, const Eigen::VectorXd& saturated_N,
                                       const Eigen::VectorXd& usable);

/// Moving average over neighbouring rows, some filter lengths wide.
Eigen::VectorXd smoothed(const Eigen::VectorXd& values);

}  // namespace slipstack::workbench
