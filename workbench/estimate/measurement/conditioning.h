// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/measurement/parts.h"

namespace slipstack::workbench {

// What is chosen from logs before anything is fitted to them.

/// Mass by plain least squares on a strongly smoothed log: only good for choosing filters. What mend() cut,
/// and what the smoothing sees of it, is left out.
double rough_mass_kg(const std::vector<double>& position_m, const std::vector<double>& force_N,
                     double rate_Hz, const std::vector<Interval>& cut);

/// Bandwidth up to which the force of joined logs tells of the motion: no further than any of them excites,
/// nor than where the encoder's steps, seen through the mass, are louder than the noise of the force. The
/// parts have their rough mass and noise.
double bandwidth_shown_Hz(const Log& log, const std::vector<LogPart>& parts);

}  // namespace slipstack::workbench
