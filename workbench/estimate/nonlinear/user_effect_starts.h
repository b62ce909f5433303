// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {

/// Points from which the search for the shapes of a user-defined effect starts, the best first. Of several
/// hundred candidates, among them the places where the residual is strongest, those are kept whose force
/// alone explains most of `residual_N` (rows). Cost: at most 800 evaluations of the expression at 12 000
/// rows.
std::vector<std::vector<double>> user_effect_starting_shapes(const Measurement& measurement,
                                                             const EffectDescription& effect,
                                                             const std::vector<ShapeRange>& ranges,
                                                             const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
