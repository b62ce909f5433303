// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// The residual in the moments after sign changes of the velocity, the acceleration or the measured force,
/// where backlash is crossed. A drive with backlash pushes one flank until the force that it transmits
/// changes sign, then crosses the gap and hits the other flank. The form of the impact depends on its
/// strength, so the residual is no function of velocity or acceleration; and it occurs at every reversal, so
/// it is no single event. It is judged by energy: the share of the squared residual within some milliseconds
/// after reversals, compared with the share of the rows that lie there, and with that of the noise floor.
/// Nothing is reported where few blocks of the log hold most of it: those are events in time. `residual_N`:
/// each row times the root of its weight.
Structure after_reversals(const Measurement& measurement, const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
