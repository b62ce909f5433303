// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// `fitted` with the standard error of every parameter that the fit was free to choose, gains and searched
/// shapes jointly: how far from the truth it may be, in two of three cases. They allow for correlation within
/// blocks, for how few blocks tell of a parameter, and for the encoder's steps, which another grid would put
/// elsewhere. Zero: given, at its bound, or without effect on the force. Not in them: what the form of the
/// model gets wrong. Cost: two evaluations of the model for each searched shape, four for the encoder, and
/// five accumulations of normal equations.
FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted);

/// `fitted` with its searched shapes, jointly with its gains, at the bottom of the squared error: one
/// Gauss-Newton step from where the search stopped, which is by how little the held-out error still fell, and
/// that may be a standard error away. Unchanged where the step does not pay. Cost: as with_standard_errors(),
/// and a fit.
FittedModel refine_all_shapes(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
