// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// A shape that the log determines, and that is not at an end of its range.
struct FreeShape {
  std::size_t term = 0;
  std::size_t shape = 0;
  double step = 0.0;  ///< of the difference quotient
  double lower = 0.0;
  double upper = 0.0;
};

/// The regression around a fitted model in all its unknowns: first the gains, then the change of each free
/// shape.
struct Tangent {
  std::vector<FreeShape> shapes;
  Eigen::MatrixXd columns;
  NormalEquations::Constraints constraints;  ///< of shapes: as far as the tangent is trusted, from 0
  Eigen::Index gains = 0;                    ///< how many of the columns belong to gains

  Eigen::Index column_of(std::size_t shape) const { return gains + static_cast<Eigen::Index>(shape); }
};

/// Cost: two evaluations of the model for each free shape.
Tangent tangent_of(const Measurement& measurement, const FittedModel& fitted);

/// The shapes that the log should have determined and that ended at an end of their range; `lower` and
/// `upper` are the effect's own bounds.
std::vector<FreeShape> shapes_at_bounds(const Measurement& measurement, const Terms& terms);

/// Derivative of (modelled - measured force) by a shape, rows. Cost: two evaluations of the model.
Eigen::VectorXd derivative_by_shape(const Measurement& measurement, const FittedModel& fitted,
                                    const FreeShape& shape);

/// Fixes the low passes among the shapes: their columns contain the noise of the force, which biases the time
/// constant towards zero.
void hold_low_pass(const FittedModel& fitted, Tangent& tangent);

/// `fitted` with its searched shapes, jointly with its gains, at the minimum of the squared error: one
/// Gauss-Newton step. A search stops when the error hardly falls any more, and may then be a
/// standard error away from the minimum. Unchanged where the step brings no improvement. Cost: tangent_of()
/// and a fit of the gains.
FittedModel refine_all_shapes(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
