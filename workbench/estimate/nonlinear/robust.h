// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit_gains.h"

namespace slipstack::workbench {

/// A fit that is robust against a few outliers.
struct RobustFit {
  FittedModel model;
  Eigen::Index outliers = 0;  ///< rows with reduced weight
  double first_s = 0.0;       ///< time of the first of them, from the start of its log
  /// Weighted residual [N] beyond which the influence of an instant no longer grows; 0: not limited.
  double limit_N = 0.0;
};

/// Huber's weights (Huber 1964): those of `plain`, reduced where a residual, weighted by `plain`, exceeds the
/// limit, so that its influence is that of a residual at the limit. Rows.
Eigen::VectorXd huber_weights(const Eigen::VectorXd& plain, const Eigen::VectorXd& residual_N,
                              double limit_N);

/// Fits the gains of `fitted` again with Huber's loss (Huber 1964) by iteratively reweighted least squares:
/// the influence of residuals is limited at five robust standard deviations (by the median of magnitudes).
/// Gaussian residuals never reach that, so the result for a clean log is the same to the last bit. The
/// weights stay on the measurement for further fits (Measurement::fit_weights()); errors count every instant
/// by its noise. Only for a complete model: the force of a missing effect is no outlier. Cost: at most five
/// fits of the gains.
RobustFit fit_robustly(Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
