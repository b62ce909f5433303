// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// White noise of the force before the filter [N], as what a model leaves bounds it.
struct NoiseEstimate {
  double least_N = 0.0;
  double most_N = std::numeric_limits<double>::infinity();
  /// What the sensor's own differences from sample to sample say, within these bounds.
  double bounded(double sensor_N) const;
};

/// The noise of one log's force. Forces that push the axis and are in no sensor (a drive's own noise, rough
/// rolling) are seen in the residual only, since the measured current of a controlled axis need not carry
/// them; and what a controller does from sample to sample is no noise, since it is measured and moves the
/// axis. Judged in the upper part of the rows' bandwidth, where friction and motion say little, of the log's
/// pieces by the median, so that neither a line nor what happens at reversals counts. At least what the
/// quietest of its bands has without what the encoder's steps do there: through `mass_kg`, and through
/// hysteresis, the mean power of `realisations_N`. At most what the loudest band has without the first of
/// these. No bounds for a log of fewer than eight pieces of 64 rows. `residual_N` and `realisations_N`: of
/// all rows; `lag`: undone in the residual, it came before the noise.
NoiseEstimate residual_noise(const Measurement& measurement, const LogPart& part,
                             const Eigen::VectorXd& residual_N,
                             const std::vector<Eigen::VectorXd>& realisations_N, double mass_kg,
                             const MeasurementDynamics& lag);

}  // namespace slipstack::workbench
