// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// What is left in the moments after reversals, of the velocity, of the acceleration or of the measured
/// force: play closes there. A drive with backlash pushes one flank until the force that it transmits changes
/// sign, crosses the gap and knocks against the other; the residual of that is a knock whose form depends on
/// how hard it was, no curve over velocity or acceleration, and not one moment but every reversal. Judged by
/// energy: the share of the squared residual within some milliseconds after reversals, above the share of the
/// rows that lie there. Nothing is found where few reversals hold most of it: those are events in time.
Structure after_reversals(const Measurement& measurement, const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
