// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/detectability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {

namespace {

/// Of a column's length, what rounding and the regularisation of ResidualMaker leave of one that the baseline
/// imitates.
constexpr double kNoneLeft = 1e-4;

/// The rms that an orthogonal force must have to be named. An effect is named if it lowers the error by
/// r = least_reduction: with the effect in the force, the error of the model without it satisfies
/// error^2 + force^2 = (error / (1 - r))^2.
double wanted_rms_N(const FittedModel& base, double least_reduction) {
  const double kept = 1.0 - least_reduction;
  return base.holdout_rmse_N * std::sqrt(1.0 / (kept * kept) - 1.0);
}

double least_N(const Measurement& measurement, const FittedModel& base, const Term& term) {
  return least_named_N(*term.effect, measurement.weighted_rms(base.linearisation->measured_N()), base.terms);
}

}  // namespace

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
  const double wanted_N = std::max(wanted_rms_N(base, least_reduction), least_N(measurement, base, term));
  if (visibility.share > 0.0) {
    // A force that acts only for a short time is reported by its peak, not by its mean over the log.
    const double peak_over_rms =
        force.cwiseAbs().maxCoeff() / std::sqrt(own / measurement.row_weights().sum());
    visibility.least_rms_N = wanted_N / std::sqrt(visibility.share);
    visibility.least_N = visibility.least_rms_N * peak_over_rms;
  }
  return visibility;
}

double detection_limit(const Measurement& measurement, const FittedModel& base,
                       const ResidualMaker& residual_maker, const Term& term, std::size_t gain) {
  const Eigen::MatrixXd column =
      weighted_columns(measurement, base, term).col(static_cast<Eigen::Index>(gain));
  const double own = column.norm();
  const double beyond = residual_maker.beyond(column).norm();
  if (!(beyond > kNoneLeft * own)) return std::numeric_limits<double>::infinity();
  const double wanted_N = std::max(wanted_rms_N(base, kLeastReduction), least_N(measurement, base, term));
  const double limit = wanted_N * std::sqrt(measurement.row_weights().sum()) / beyond;
  const bool is_delay = term.gains.empty();
  const double least_s = term.effect->traits.plausible.least_samples * measurement.tick_s();
  return is_delay ? std::max(limit, least_s) : limit;
}

}  // namespace slipstack::workbench
