// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit_gains.h"

namespace slipstack::workbench {

/// Releases shapes that are held at a nominal value, where the held-out error demands it. To be called once
/// all effects are known: viscous friction that the model lacks would make a quadratic drag look like one of
/// lower exponent. For the same reason the exponent of a drag is not lowered beside viscous friction.
FittedModel refine_nominal_shapes(const Measurement& measurement, FittedModel fitted);
/// The same for `time_delay` alone: a low pass in series with the delay, where there is one.
FittedModel refine_delay(const Measurement& measurement, FittedModel fitted);

}  // namespace slipstack::workbench
