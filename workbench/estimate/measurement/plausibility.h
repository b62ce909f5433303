// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

// Inputs that contradict physics: a force of the wrong sign, one without a sign, wrong units. No model of
// friction is needed to see them, and every model is misled by them.
namespace slipstack::workbench {

struct InputWarning {
  std::string kind;  ///< "clocks", "force_sign", "force_unsigned", "reference", "units"
  std::string what;  ///< one line: what contradicts what, and what to check
};

/// What of the recorded force and motion cannot be as declared:
///
/// - clocks: the force follows from the motion far better at a lag that no drive has (clocks.h).
/// - force_sign: friction takes energy out of the motion, so the work of the force beyond kinetic energy and
///   potential is positive, and the mass is. A force with the other sign has both negative.
/// - force_unsigned: a force that is never negative while the axis moves both ways, and that follows from
///   the motion much better as a magnitude.
/// - units: the inertia in the force is a thousandfold of the declared mass, or another factor between units;
///   or an axis on guideways that moves faster than any.
/// - reference: the position follows the recorded reference in another unit or with the other sign.
///
/// Empty for a plausible log, and where the log does not show it. Cost: four signals through the common
/// filter, O(samples), and that of clock_difference().
std::vector<InputWarning> input_warnings(const Measurement& measurement);

}  // namespace slipstack::workbench
