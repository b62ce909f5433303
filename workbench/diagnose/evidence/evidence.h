// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// The evidence text of one effect of a model with standard errors (with_standard_errors()): each fitted
/// value with two standard errors to either side, of a map its largest value over the travel that the log has
/// shown, of what differs between the directions the friction each way. What ended at a bound is said to be
/// not identified. Cost: for an effect that differs between the directions, one bounded solution per block.
std::string evidence_of(const FittedModel& model, std::string_view effect);

/// The same without intervals beyond those that `fitted` has. `model`: all terms with which it was fitted.
std::string evidence_of(const Term& fitted, const Terms& model);

}  // namespace slipstack::workbench
