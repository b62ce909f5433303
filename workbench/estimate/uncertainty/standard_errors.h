// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// `fitted` with the standard error of every parameter that the fit was free to choose, gains and searched
/// shapes jointly, and of the level of its hysteresis: the true value lies within it in two of three cases.
/// It accounts for correlation within blocks, for the small number of blocks that determine a parameter, for
/// the encoder's quantisation, for shapes that ended at a bound of their search or beside the minimum, and,
/// where the log has the reference of a controlled axis, for the bias by noise that moves the axis
/// (instruments.h). Zero: the parameter was given, is at its bound, or has no influence on the force. Errors
/// of the form of the model are not included, nor that bias where the log has no reference. Cost: two
/// evaluations of the model for each searched shape, seven for the encoder (of the dry friction alone), one
/// accumulation of normal equations, and that of instruments.h.
FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
