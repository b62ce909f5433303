// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// How well a log separates one effect from another.
struct Separation {
  std::string effect;
  std::string other;
  /// The angle between the force of `effect` and the space of forces of `other`, both orthogonal to the
  /// model beside them: 0 where `other` can imitate `effect`, 90 where they have nothing in common.
  double angle_deg = 0.0;
  /// The squared part of the effect's force that `other` cannot imitate, divided by the variance of the
  /// noise: the expected increase of chi squared if the wrong one of the two is named.
  double chi_squared = 0.0;
};

/// The columns of a term at the rows, each row multiplied by the root of its weight. A delay has no gain; its
/// column is the derivative of the force.
Eigen::MatrixXd weighted_columns(const Measurement& measurement, const FittedModel& base, const Term& term);

/// The residual of the model at the rows, each multiplied by the root of its weight.
Eigen::VectorXd weighted_residual(const Measurement& measurement, const FittedModel& model);

/// The residual maker I - K (K'K)^-1 K' of some columns K (econometrics: annihilator matrix); factored once,
/// applied to many others.
class ResidualMaker {
 public:
  explicit ResidualMaker(const Eigen::MatrixXd& known);
  /// `columns` minus their projection on the known columns.
  Eigen::MatrixXd beyond(const Eigen::MatrixXd& columns) const;

 private:
  Eigen::MatrixXd unit_;
  Eigen::LDLT<Eigen::MatrixXd> gram_;
};

/// The columns of `base` whose gains are free, weighted as those of weighted_columns().
Eigen::MatrixXd weighted_free_columns(const Measurement& measurement, const FittedModel& base);

/// The residual maker of weighted_free_columns().
ResidualMaker baseline_residual_maker(const Measurement& measurement, const FittedModel& base);

/// The gains of a term. Where none is fitted: 1 for the gain whose column in `beyond_base` is largest, 0 for
/// the others.
Eigen::VectorXd seen_gains(const Term& term, const Eigen::MatrixXd& beyond_base);

/// The residual that `base` is expected to leave at the rows if the axis has the term: the force of the term
/// minus its projection on the free columns of `base`.
Eigen::VectorXd expected_residual_N(const FittedModel& base, const Term& term);

/// Every term against every other, with the shapes as they are: canonical angles between regressors that were
/// made orthogonal to those of `base`. `noise_N`: rms of the noise at the rows. Cost: the columns of every
/// term once.
std::vector<Separation> separations(const Measurement& measurement, const FittedModel& base,
                                    const Terms& terms, double noise_N);

}  // namespace slipstack::workbench
