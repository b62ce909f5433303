// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// The model with shapes that have a customary value where held-out data want them, once it is known which
/// effects there are: viscous friction beside quadratic drag looks like a drag of lower exponent. Beside a
/// viscous friction the exponent of a drag is therefore not lowered.
FittedModel refine_nominal_shapes(const Measurement& measurement, FittedModel fitted);
/// The same for `time_delay` alone: a low pass beside the delay, where there is one.
FittedModel refine_delay(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
