// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sim_host/plant/axis.h"
#include "workbench/loop/comparison/trajectory.h"

namespace slipstack::workbench {

/// The friction of the simulated axis on this motion, started relaxed, N: its own elements moved along the
/// reference. A value for each tick, the mean over the time in which the drive holds its current. No model
/// knows more, so what is left with it is the least that a feed-forward of friction can leave. Effects of the
/// axis are not in it. About 0.1 µs per tick.
std::vector<double> known_friction_N(const sim::Axis& axis, const Trajectory& trajectory);

}  // namespace slipstack::workbench
