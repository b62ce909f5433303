// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/measurement/motion_terms.h"

// Force and position that were recorded by two devices, each with a clock of its own.
namespace slipstack::workbench {

/// By how much the force is late against the motion.
struct ClockDifference {
  double force_late_s = 0.0;  ///< negative: it is early
  double resolution_s = 0.0;  ///< between two lags that were tried
};

/// The lag at which the force follows from the motion far better than at any lag that the catalogue's delay
/// can have, within half a second to either side; none where there is no such lag. The force is fitted by the
/// terms of the motion and stop operators of fixed slip distances: hysteresis lags the motion too, and
/// without it a shifted force would imitate it. Asked only where the inertia is between half of the force and
/// twice of it. Cost: a signal through the common filter for each stop operator, and rows x lags.
std::optional<ClockDifference> clock_difference(const Measurement& measurement, const MotionTerms& terms);

}  // namespace slipstack::workbench
