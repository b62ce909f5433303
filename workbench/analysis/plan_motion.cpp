// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/plan_motion.h"

#include <fmt/format.h>

#include <optional>

#include "workbench/base/errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/plan/limits.h"
#include "workbench/report/results/plan_result.h"

namespace slipstack::workbench {
namespace {

/// Throws InputError for a plan that would show less than what is known already.
void refuse_less_than_known(const std::vector<ExpectedEvidence>& so_far, const Plan& plan) {
  const std::optional<LeastEvidence> least = least_evidence(so_far, plan.expected);
  if (!least || least->plan >= least->log) return;
  throw InputError(
      fmt::format("within these limits the best motion of {:.3g} s is expected to give less evidence "
                  "({:.3g}) than the log in "
                  "hand ({:.3g}), so it is not written; allow more with --limits or --seconds",
                  plan.motion.duration_s(), least->plan, least->log));
}

}  // namespace

void check_plan(const PlanRequest& request) {
  declare_effects(request.user_effects);
  for (const std::string& id : parse_effects(request.effects)) {
    if (!find_effect(id)->is_plannable()) {
      throw UsageError(fmt::format("--for: no experiment can be planned for {}; name another effect", id));
    }
  }
  if (!(request.seconds >= 5.0 && request.seconds <= 3600.0))
    throw UsageError("--seconds: must be between 5 and 3600");
  if (!(request.rate_Hz >= 200.0 && request.rate_Hz <= 20000.0)) {
    throw UsageError("--rate: must be between 200 and 20000 Hz");
  }
}

ExperimentResult plan_motion(const PlanRequest& request, Progress& progress) {
  const std::vector<std::string> ids = parse_effects(request.effects);
  const GivenLimits given = parse_limits(request.limits);
  AxisLimits limits;
  if (request.logs.empty()) limits = limits_of_axis(given);
  KnownAxis known = known_axis(request, ids, progress);
  if (known.measurement) {
    limits = limits_of_axis(given, known.reached, known.measurement->log().motor_constant_N_per_A);
  }
  const Plan plan = plan_experiment(
      known.knowledge, {limits, request.seconds,
                        [&](const std::string& stage, double fraction) { progress.show(stage, fraction); }});
  if (known.measurement) {
    known.so_far = expected_evidence(*known.measurement, known.base, plan.effects);
    refuse_less_than_known(known.so_far, plan);
  }
  return plan_result(request, known, limits, plan);
}

}  // namespace slipstack::workbench
