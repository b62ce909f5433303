// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/nonlinear/shape_search.h"

namespace slipstack::workbench {

/// Points from which the search for the shapes of a user's own effect starts, the most promising first: of
/// several hundred, places where the residual is loud among them, those whose force explains most of
/// `residual_N` (rows) by itself. Cost: at most 800 evaluations of the expression at 12 000 rows.
std::vector<std::vector<double>> user_effect_starting_shapes(const Measurement& measurement,
                                                             const EffectDescription& effect,
                                                             const std::vector<ShapeRange>& ranges,
                                                             const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
