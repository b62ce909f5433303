// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// `fitted` with the standard error of every parameter that the fit was free to choose, gains and searched
/// shapes jointly: the true value lies within it in two of three cases. It accounts for correlation within
/// blocks, for the small number of blocks that determine a parameter, and for the encoder's quantisation.
/// Zero: the parameter was given, is at its bound, or has no influence on the force. Errors of the form of
/// the model are not included. Cost: two evaluations of the model for each searched shape, four for the
/// encoder, and five accumulations of normal equations.
FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
