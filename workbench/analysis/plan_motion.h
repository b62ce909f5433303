// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/console/progress.h"
#include "workbench/plan/known_axis.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// Throws UsageError for a request out of its ranges, or for an effect that no experiment can show.
void check_plan(const PlanRequest& request);

/// The work of `slipstack experiment plan`; `file` of the result holds the set points. Throws UsageError, and
/// InputError for a plan that would show less than what is known already.
ExperimentResult plan_motion(const PlanRequest& request, Progress& progress);

}  // namespace slipstack::workbench
