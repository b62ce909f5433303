// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// Fits all gains of `terms` and leaves their shapes unchanged: bounded least squares, repeated
/// (Gauss-Newton) where effects multiply each other. `known`, a model with some of the same effects, saves
/// building their columns again.
FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known = nullptr);

/// A model linearised at its present gains, which are not fitted: what try_effect() needs as a base.
/// `error_N` is the residual error that is already known for it; `known` as for fit_gains().
FittedModel linearised(const Measurement& measurement, Terms terms, double error_N,
                       const FittedModel* known = nullptr);

/// Sets the errors of a model on the data of its linearisation: `train_rmse_N` and `relative_error`.
void set_errors_in_sample(const Measurement& measurement, FittedModel& model);

}  // namespace slipstack::workbench
