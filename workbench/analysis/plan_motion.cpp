// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/plan_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "workbench/base/errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/plan/limits.h"
#include "workbench/report/results/plan_result.h"

namespace slipstack::workbench {
namespace {

constexpr double kShortestPlan_s = 5.0;
constexpr double kLongestPlan_s = 3600.0;
/// Where no duration is asked for: of a plan, and of one that is repeated to show more than the log.
constexpr double kPlan_s = 60.0;
constexpr double kLogsToShowMore = 2.0;

/// How long a motion may be repeated.
double longest_repeated_s(const PlanRequest& request, const KnownAxis& known) {
  if (request.seconds) return *request.seconds;
  const double log_s = known.measurement ? known.measurement->duration_s() : 0.0;
  return std::clamp(kLogsToShowMore * log_s, kPlan_s, kLongestPlan_s);
}

/// Throws InputError for a plan that would show less than what is known already.
void refuse_less_than_known(const Plan& plan) {
  const std::optional<LeastEvidence> least = least_evidence(plan.in_hand, plan.expected);
  if (!least || least->plan >= least->log) return;
  const double needed_s = 1.2 * plan.motion.duration_s() * least->log / std::max(least->plan, 1e-300);
  const std::string longer =
      needed_s <= kLongestPlan_s ? fmt::format(", or {:.0f} s with --seconds", std::ceil(needed_s)) : "";
  throw InputError(
      fmt::format("within these limits the best motion of {:.3g} s is expected to give less evidence "
                  "({:.3g}) than the log in "
                  "hand ({:.3g}), so it is not written; allow more with --limits{}",
                  plan.motion.duration_s(), least->plan, least->log, longer));
}

}  // namespace

void check_plan(const PlanRequest& request) {
  declare_effects(request.user_effects);
  for (const std::string& id : parse_effects(request.effects)) {
    if (!find_effect(id)->is_plannable()) {
      throw UsageError(fmt::format("--for: no experiment can be planned for {}; name another effect", id));
    }
  }
  const double seconds = request.seconds.value_or(kPlan_s);
  if (!(seconds >= kShortestPlan_s && seconds <= kLongestPlan_s)) {
    throw UsageError(fmt::format("--seconds: must be between {} and {}", kShortestPlan_s, kLongestPlan_s));
  }
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
      known.knowledge,
      {.limits = limits,
       .seconds = request.seconds.value_or(kPlan_s),
       .in_hand = [&](const Terms& effects) { return known.evidence_in_hand(effects); },
       .progress = [&](const std::string& stage, double fraction) { progress.show(stage, fraction); },
       .repeated_s = longest_repeated_s(request, known)});
  refuse_less_than_known(plan);
  return plan_result(request, known, limits, plan);
}

}  // namespace slipstack::workbench
