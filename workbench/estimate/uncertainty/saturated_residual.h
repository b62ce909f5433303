// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What no smooth dependence on the state explains, N at the rows: the residual of a model whose gains are
/// fitted again, without bounds, beside free curves over position, velocity, acceleration and time, and over
/// position, acceleration and time times the model's dry friction. Its mean square is the pure error of a
/// lack-of-fit test (Draper and Smith, Applied Regression Analysis, 1998, section 2.1), which does not depend
/// on which effects a model of the axis has. Cost: rows x (gains + 14)^2.
Eigen::VectorXd saturated_residual_N(const Measurement& measurement, const Linearisation& model);

}  // namespace slipstack::workbench
