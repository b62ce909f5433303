// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

// Inputs that contradict physics: a force of the wrong sign, one without a sign, wrong units. No model of
// friction is needed to see them, and every model is misled by them.
namespace slipstack::workbench {

struct InputWarning {
  std::string kind;  ///< "force_sign", "force_unsigned", "units"
  std::string what;  ///< one line: what contradicts what, and what to check
};

/// What of the recorded force and motion cannot be as declared:
///
/// - force_sign: friction takes energy out of the motion, so the work of the force beyond kinetic energy and
///   potential is positive, and the mass is. A force with the other sign has both negative.
/// - force_unsigned: a force that is never negative while the axis moves both ways, and that follows from
///   the motion much better as a magnitude.
/// - units: the inertia in the force is a thousandfold of the declared mass, or another factor between units;
///   or an axis on guideways that moves faster than any.
///
/// Empty for a plausible log, and where the log does not show it. Cost: four signals through the common
/// filter, O(samples).
std::vector<InputWarning> input_warnings(const Measurement& measurement);

}  // namespace slipstack::workbench
