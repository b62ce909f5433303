// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// `fitted` with the standard error of every parameter that the fit was free to choose, gains and searched
/// shapes jointly: the true value lies within it in two of three cases. It accounts for correlation within
/// blocks, for the small number of blocks that determine a parameter, for the encoder's quantisation as far
/// as the log supports it, and for shapes that ended at a bound of their search. Zero: the parameter was
/// given, is at its bound, or has no influence on the force. Errors of the form of the model are not
/// included, nor the bias where noise moves a controlled axis. Where
/// weigh_rows() was not called, quantisation counts in full. Cost: two evaluations of the model for each
/// searched shape, seven for the encoder (of the dry friction alone), and one accumulation of normal
/// equations.
FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
