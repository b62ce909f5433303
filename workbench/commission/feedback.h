// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/frequency/tune.h"
#include "workbench/loop/live_axis.h"
#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// A feedback, and its margins on the rigid mass that it is made for.
struct Feedback {
  DriveController gains;
  Margins margins;
};

/// What `slipstack tune` proposes for a rigid mass (frequency/rigid_mass.h), with the modulus margin that it
/// asks for by default. Some tenths of a second.
Feedback full_feedback(double mass_kg, double tick_s);

/// The same with all of its three gains at this share, and the margins that it has then.
Feedback part_of(const Feedback& full, double share);

/// What the drive is given: a feedback, and limits a little beyond those that motions keep to.
DriveSettings settings_of(const Feedback& feedback, const AxisLimits& limits, double force_limit_N);

/// Whether a record of an axis that holds its place between these times scatters in its force by less than
/// `most_N` (standard deviation).
bool is_steady(const AxisRecord& record, double from_s, double to_s, double most_N);

}  // namespace slipstack::workbench
