// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/control/parameters/parameters.h"
#include "sim_host/plant/axis.h"

namespace slipstack::workbench {

/// A conservative tuning of the controller for an axis of which mass, motor and encoder are known: the
/// velocity loop at 170 rad/s, the position loop a quarter of that, no notch, no adaptation.
AxisParameters loop_parameters(const sim::Axis& axis, double tick_s);

/// Encoder, motor and tick of an axis, and the limits of the supervision that follow from them. Feedback and
/// motion as parameters.h has them.
AxisParameters supervised_axis(double encoder_resolution_m, double motor_constant_N_per_A,
                               double current_limit_A, double tick_s);

/// Feed-forward of the mass alone.
ModelParameters mass_only_model(double mass_kg);

}  // namespace slipstack::workbench
