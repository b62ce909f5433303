// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// A baseline for a log of which nothing is known: the inertia, unless the log declares a mass of zero;
/// hysteresis, or Coulomb friction where the log does not show the pre-sliding displacement; viscous friction
/// where it is significant. An effect of more parameters is chosen by the criteria by which diagnose() names
/// one (evidence/reduction.h). Cost: four fits.
std::vector<std::string> chosen_baseline(const Measurement& measurement);

}  // namespace slipstack::workbench
