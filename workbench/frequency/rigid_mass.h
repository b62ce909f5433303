// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/frequency/tune.h"

namespace slipstack::workbench {

/// The response of a rigid mass whose force is held from tick to tick, from 2 Hz to a fifth of the tick's
/// rate: T²/(2m) (z + 1)/(z − 1)² (Åström and Wittenmark, Computer-Controlled Systems, 3rd ed. 1997, 2.3).
/// For an axis whose response nobody has measured; a resonance it does not know of.
std::vector<ResponsePoint> rigid_mass_response(double mass_kg, double tick_s);

/// What propose() makes of that, from the drive's usual gains, with a velocity loop no faster than the
/// observer: beyond its bandwidth the estimate follows the force that the model expects, not the axis, and
/// the margin would rest on a mass that nobody has measured there. Throws std::logic_error where nothing
/// keeps the margin.
DriveController feedback_for_mass(double mass_kg, double tick_s, double observer_rad_per_s,
                                  const TuneRequest& request);

}  // namespace slipstack::workbench
