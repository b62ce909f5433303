// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// How well a log tells one effect from another.
struct Separation {
  std::string effect;
  std::string other;
  /// Between the force of `effect` and all that `other` can make, both without what the baseline imitates: 0
  /// when the one passes for the other, 90 when they share nothing.
  double angle_deg = 0.0;
  /// What of the effect's force `other` leaves unexplained, squared, over the noise's variance: expected
  /// growth of chi squared where the wrong one is named.
  double chi_squared = 0.0;
};

/// Columns of a term at the rows, each row by the root of its weight. A delay has no gain: its column is the
/// slope of the force.
Eigen::MatrixXd weighted_columns(const Measurement& measurement, const FittedModel& base, const Term& term);

/// What the model leaves at the rows, each by the root of its weight.
Eigen::VectorXd weighted_residual(const Measurement& measurement, const FittedModel& model);

/// What some columns can imitate; factored once, asked for many others.
class ResidualMaker {
 public:
  explicit ResidualMaker(const Eigen::MatrixXd& known);
  /// `columns` without what the known ones imitate.
  Eigen::MatrixXd beyond(const Eigen::MatrixXd& columns) const;

 private:
  Eigen::MatrixXd unit_;
  Eigen::LDLT<Eigen::MatrixXd> gram_;
};

/// Columns of `base` whose gains a fit may choose, as those of weighted_columns().
Eigen::MatrixXd weighted_free_columns(const Measurement& measurement, const FittedModel& base);

/// What the free gains of `base` imitate, its rows by the root of their weights.
ResidualMaker baseline_residual_maker(const Measurement& measurement, const FittedModel& base);

/// The gains of a term, those of one that was not fitted replaced by the one that is seen best.
Eigen::VectorXd seen_gains(const Term& term, const Eigen::MatrixXd& beyond_base);

/// What a model without the term leaves at the rows where the axis has it: its force without what the free
/// gains of `base` take up.
Eigen::VectorXd expected_residual_N(const FittedModel& base, const Term& term);

/// Every term against every other, at their shapes as they are: canonical angles between residualised
/// regressors. `noise_N`: rms of the noise at the rows. Cost: the columns of every term once.
std::vector<Separation> separations(const Measurement& measurement, const FittedModel& base,
                                    const Terms& terms, double noise_N);

}  // namespace slipstack::workbench
