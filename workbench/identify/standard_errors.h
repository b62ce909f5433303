// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/identify/fit.h"

namespace slipstack::workbench {

/// `fitted` with the standard error of every parameter that the fit was free to choose, gains and searched
/// shapes jointly: how far another record of the same axis would land. They allow for correlation within
/// blocks (the sandwich estimator over blocks; Huber 1967). Zero: given, at its bound, or without effect on
/// the force. Cost: two evaluations of the model for each searched shape, and one accumulation of normal
/// equations.
FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
