// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// A low pass that the recorded force went through alone, without the motion, as published logs often did.
struct ForceFilter {
  double cut_Hz = 0.0;   ///< where it lets half of the amplitude pass
  double flat_Hz = 0.0;  ///< up to where it takes less than 2 % of the amplitude
};

/// The filter of a force whose noise is not white, or less than any sensor's, from what a mass with
/// hysteresis predicts of the force: the ratio of both falls, as that of a Butterworth filter does, to less
/// than a tenth where the motion is known, three times the band. No mechanics do that to the whole force:
/// above a mode the mass of the rotor remains. None for a force with white noise of a sensor, where the force
/// excites too little to tell, and where too few rows would be left below it. Cost: a fit.
std::optional<ForceFilter> filter_of_force(const Measurement& measurement);

}  // namespace slipstack::workbench
