// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// A fit that a few wild instants did not lead astray.
struct RobustFit {
  FittedModel model;
  Eigen::Index outliers = 0;  ///< rows that weigh less than they would
  double first_s = 0.0;       ///< time of the first, from the start of its log
  /// Weighted residual [N] beyond which an instant pulls no more; 0: all pull as they do.
  double limit_N = 0.0;
};

/// Huber's weights (Huber 1964): those of `plain`, less where a residual, weighted by `plain`, is beyond the
/// limit, so that it pulls no more than at the limit. Rows.
Eigen::VectorXd huber_weights(const Eigen::VectorXd& plain, const Eigen::VectorXd& residual_N,
                              double limit_N);

/// `fitted` again with Huber's loss (Huber 1964) by iterated weights: rows whose residual is beyond five
/// robust standard deviations (of the median of magnitudes) pull no more than at five. Gaussian residuals
/// never get there, so a clean log gives the same answer to the last bit. The weights stay on the
/// measurement: held-out errors are then those of the good instants. For a model that is complete: of one
/// that lacks an effect, what the effect does is no outlier. Cost: as many fits of the gains as it takes,
/// five at most.
RobustFit fit_robustly(Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
