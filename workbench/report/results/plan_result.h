// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/plan/known_axis.h"
#include "workbench/plan/limits.h"
#include "workbench/plan/segment_choice.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// The result of `experiment plan`: the motion, what it reaches within which limits, and the evidence that it
/// is expected to give beside that of the logs. Its file is the set points.
ExperimentResult plan_result(const PlanRequest& request, const KnownAxis& known, const AxisLimits& limits,
                             const Plan& plan);

}  // namespace slipstack::workbench
