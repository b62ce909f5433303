// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// The model whose residual becomes the saturated one (saturated_residual.h): mass and hysteresis with what
/// bends them most, viscous friction and a mass beside the declared one, and with the forces that no smooth
/// curve describes. `measurement` is a copy; it gets slip distances of its own. Cost: two fits of mass and
/// hysteresis, a search of shapes for each periodic effect of the catalogue.
FittedModel reference_model(Measurement& measurement);

}  // namespace slipstack::workbench
