// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// A short interval in which the force changes from sample to sample more than anywhere else in the logs: a
/// loose plug, a knock against the sensor. It is searched in the samples, because rows around a reversal of
/// the axis have so little weight that the residual may not show it; changes count beyond those of the model
/// there, which follow from the motion. `model_N`: the force of the model at every sample; `residual_N`: its
/// residual at the rows. Cost: O(samples).
std::optional<Structure> burst_in_force(const Measurement& measurement, const std::vector<double>& model_N,
                                        const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
