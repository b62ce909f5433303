// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "workbench/estimate/nonlinear/tangent.h"

namespace slipstack::workbench {

/// Square of the bias of each unknown of the tangent, then of each sum of unknowns in the columns of `sums`,
/// that least squares has on an axis under control. There the noise of the force moves the axis, and its
/// motion in turn the force, so that the columns correlate with the noise. The reference knows nothing of the
/// noise: along the motion that it alone causes, the columns are instrumental variables (Soderstrom and
/// Stoica 1983; for inverse dynamics Janot, Vandanjon and Gautier 2014). The bias is the difference between
/// both estimates, as far as it exceeds the scatter of the difference (Hausman 1978), which is summed within
/// parts of the blocks.
///
/// The motion is the response of the position to the reference and to the model's force along it, by two
/// finite impulse responses that are fitted to the log (two-stage method; Van den Hof and Schrama 1993). The
/// elements of a hysteresis are one unknown, their common factor: their columns are nearly collinear. Time
/// constants of low passes are held: their columns are the measured force.
///
/// Zero where the log has no reference, or is the reference. Cost: two evaluations of the model, its columns,
/// two evaluations for each free shape, and rows x taps^2.
Eigen::VectorXd squared_bias_by_control(const Measurement& measurement, const FittedModel& fitted,
                                        const Tangent& tangent, const BoundedSolution& solution,
                                        const Eigen::MatrixXd& sums);

}  // namespace slipstack::workbench
