// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/detectability.h"

#include <cmath>
#include <limits>

namespace slipstack::workbench {

Visibility visibility_of(const Measurement& measurement, const FittedModel& base,
                         const ResidualMaker& residual_maker, const Term& term, double least_reduction) {
  const Eigen::MatrixXd columns = weighted_columns(measurement, base, term);
  const Eigen::MatrixXd left = residual_maker.beyond(columns);
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(columns.cols());
  for (std::size_t i = 0; i < term.gains.size(); ++i) gains(static_cast<Eigen::Index>(i)) = term.gains[i];
  const bool fitted = (columns * gains).squaredNorm() > 0.0;
  if (!fitted) {  // of several gains the one with the largest orthogonal part
    Eigen::Index best = 0;
    left.colwise().squaredNorm().maxCoeff(&best);
    if (columns.cols() > 0) gains(best) = 1.0;
  }
  const Eigen::VectorXd force = columns * gains;
  const double own = force.squaredNorm();
  const double beyond = (left * gains).squaredNorm();
  Visibility visibility{term.id(), own > 0.0 ? beyond / own : 0.0, std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::infinity()};
  // The effect is named if it lowers the error by r = least_reduction: with the effect in the force, the
  // error of the model without it satisfies error^2 + share x force^2 = (error / (1 - r))^2.
  const double kept = 1.0 - least_reduction;
  const double wanted_N = base.holdout_rmse_N * std::sqrt(1.0 / (kept * kept) - 1.0);
  if (visibility.share > 0.0) {
    // A force that acts only for a short time is reported by its peak, not by its mean over the log.
    const double peak_over_rms =
        force.cwiseAbs().maxCoeff() / std::sqrt(own / measurement.row_weights().sum());
    visibility.least_rms_N = wanted_N / std::sqrt(visibility.share);
    visibility.least_N = visibility.least_rms_N * peak_over_rms;
  }
  return visibility;
}

}  // namespace slipstack::workbench
