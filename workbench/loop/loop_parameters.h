// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/control/parameters/parameters.h"
#include "sim_host/plant/axis.h"

namespace slipstack::workbench {

/// A conservative tuning of the controller for an axis of which mass, motor and encoder are known: the
/// velocity loop at 170 rad/s, the position loop a quarter of that, no notch, no adaptation.
AxisParameters loop_parameters(const sim::Axis& axis, double tick_s);

/// Feed-forward of the mass alone.
ModelParameters mass_only_model(const sim::Axis& axis);

}  // namespace slipstack::workbench
