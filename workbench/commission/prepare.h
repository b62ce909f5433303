// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/commission/feedback.h"
#include "workbench/commission/stages.h"

namespace slipstack::workbench {

/// An axis that can be moved.
struct PreparedAxis {
  double mass_kg = 0.0;
  double friction_N = 0.0;  ///< that slides, the larger one of both directions
  AxisLimits limits;
  Feedback feedback;
  DriveSettings settings;
  std::string travel_log;  ///< from end to end
};

/// Until the axis can be moved safely:
///
///   direction   the drive's check by a push; a reversed motor is turned round, and checked again
///   mass        pulses of the force that grow until the motion shows it (mass.h)
///   feedback    for that mass with the margin of `slipstack tune`; from a fifth of it upwards, as long as
///   the
///               axis is steady, and two steps back where it is not
///   ends        where the travel is not known: slowly and with little force to either end, in steps that
///   grow,
///               until a stop holds the axis or a limit switch stops it, and there a second time
///   travel      slowly from end to end, with little more force than friction takes
///
/// The direction is checked again in every run of the command; somebody may have been at the wires.
/// Throws CommissionStopped where the axis is unfit, and on a fault.
PreparedAxis prepare(Stages& stages);

}  // namespace slipstack::workbench
