// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/model.h"

// The model file of a fit: the fitted terms, and those that the controller runs.
namespace slipstack::workbench {

/// `fitted` with the hysteresis reduced to the number of elements that the controller has.
FittedModel on_controller(const Measurement& measurement, const FittedModel& fitted);

/// The model file of a fit. `reduced`: what on_controller() made of `fitted`. Of user-defined effects, whose
/// expressions the controller does not evaluate, the first that has a table is given to the controller as
/// that table; the others are left out, with the reason. The error that the file states for the controller
/// includes the cost of both.
Model model_of(const std::string& log, const Measurement& measurement, const FittedModel& fitted,
               const FittedModel& reduced, double floor_N);

}  // namespace slipstack::workbench
