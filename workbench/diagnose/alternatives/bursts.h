// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// A short stretch in which the force jumps about from sample to sample as nowhere else in the logs: a loose
/// plug, a knock against the sensor. Rows around a turn of the axis count so little that it may not be heard
/// there. `residual_N`: what the model leaves at the rows. Cost: O(samples).
std::optional<Structure> burst_in_force(const Measurement& measurement, const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
