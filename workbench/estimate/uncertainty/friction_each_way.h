// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// Friction in steady motion, forward (velocity positive) and backward, both positive where they oppose it.
/// What a map over position, acceleration or time makes of it is left out.
struct FrictionEachWay {
  double dry_forward_N = 0.0;
  double dry_backward_N = 0.0;
  double slope_forward = 0.0;  ///< viscous friction by velocity [N s/m]
  double slope_backward = 0.0;
  /// The dry friction and the constant force of the model, which adds to one way what it takes from the
  /// other.
  double with_constant_forward_N = 0.0;
  double with_constant_backward_N = 0.0;
};

/// The friction of a model with one effect that makes it differ between the directions; of several gain sets
/// the first. `term` belongs to `model`.
FrictionEachWay friction_each_way(const Terms& model, const Term& term);

/// Its standard errors by jackknife_error(). Cost: one bounded solution for each block.
FrictionEachWay standard_errors_each_way(const FittedModel& fitted, std::string_view effect);

/// The terms of a model fitted without each block of the log in turn, shapes held; empty where the model was
/// not fitted. Cost: one bounded solution for each block.
std::vector<Terms> terms_without_blocks(const FittedModel& fitted);

/// The standard error of a function of the gains from its values without each block: the delete-one jackknife
/// (Shao and Tu 1995, 1.2). It holds for any smooth function, such as the sum of two gains that nearly
/// cancel.
double jackknife_error(const std::vector<double>& values);

}  // namespace slipstack::workbench
