// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/plan_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {
namespace {

const ExpectedEvidence* find_evidence(const std::vector<ExpectedEvidence>& all,
                                      const ExpectedEvidence& like) {
  for (const ExpectedEvidence& one : all) {
    if (one.effect == like.effect && one.other == like.other) return &one;
  }
  return nullptr;
}

ExperimentTable evidence_table(const Plan& plan) {
  ExperimentTable table{"evidence",
                        "Expected evidence",
                        {{"effect", "effect", ""},
                         {"other", "separated from", ""},
                         {"log_angle_deg", "angle, log", "deg", 1.0, 3},
                         {"angle_deg", "angle, plan", "deg", 1.0, 3},
                         {"log_evidence", "evidence, log", "", 1.0, 3},
                         {"evidence", "evidence, plan", "", 1.0, 3}},
                        {}};
  const double none = std::nan("");
  for (const ExpectedEvidence& one : plan.expected) {
    const ExpectedEvidence* log = find_evidence(plan.in_hand, one);
    table.rows.push_back({one.effect, one.other.empty() ? std::string("nothing") : one.other,
                          log == nullptr ? none : log->angle_deg, one.angle_deg,
                          log == nullptr ? none : log->evidence, one.evidence});
  }
  return table;
}

/// What the log did, what is allowed and what is planned, side by side.
ExperimentTable limits_table(const KnownAxis& known, const AxisLimits& limits, const AxisLimits& planned) {
  ExperimentTable table{"limits",
                        "Log and plan",
                        {{"quantity", "", ""},
                         {"log", "log", "", 1.0, 4},
                         {"limit", "limit", "", 1.0, 4},
                         {"plan", "plan", "", 1.0, 4},
                         {"unit", "unit", ""}},
                        {}};
  const double none = std::nan("");
  const MotionExtremes& log = known.reached;
  const auto row = [&](const std::string& quantity, const char* unit, double did, double limit, double plan) {
    table.rows.push_back(
        {quantity, known.measurement ? did : none, limit > 0.0 ? limit : none, plan, axis_unit(unit)});
  };
  table.rows.push_back({std::string("lowest position"), known.measurement ? log.low_m : none, limits.low_m,
                        planned.low_m, axis_unit("m")});
  table.rows.push_back({std::string("highest position"), known.measurement ? log.high_m : none, limits.high_m,
                        planned.high_m, axis_unit("m")});
  row("velocity", "m/s", log.velocity_mps, limits.velocity_mps, planned.velocity_mps);
  row("acceleration", "m/s2", log.acceleration_mps2, limits.acceleration_mps2, planned.acceleration_mps2);
  row("jerk", "m/s3", log.jerk_mps3, limits.jerk_mps3, planned.jerk_mps3);
  // Of a plan only the force of the model is known: it is set beside that of the log's, not beside the
  // measured.
  const std::string force = axis_is_rotary() ? "torque" : "force";
  if (known.measurement) row(force + ", measured", "N", known.measured_force_N, 0.0, none);
  row(force + ", by the model", "N", known.model_force_N, limits.force_N, planned.force_N);
  return table;
}

ExperimentTable pieces_table(const Plan& plan) {
  ExperimentTable table{"segments", "The motion", {{"segment", "#", "", 1.0, 0}, {"what", "what", ""}}, {}};
  for (std::size_t i = 0; i < plan.segments.size(); ++i) {
    table.rows.push_back({static_cast<double>(i + 1), plan.segments[i]});
  }
  return table;
}

}  // namespace

ExperimentResult plan_result(const PlanRequest& request, const KnownAxis& known, const AxisLimits& limits,
                             const Plan& plan) {
  AxisLimits reached = extremes_of(plan.motion);
  reached.force_N = plan.peak_force_N;
  ExperimentResult result;
  result.experiment = "plan";
  result.setup = request.logs.empty()
                     ? request.model.empty() ? "an axis of which only the limits are known" : request.model
                     : joined(request.logs);
  const auto weakest = std::min_element(plan.expected.begin(), plan.expected.end(),
                                        [](const auto& a, const auto& b) { return a.evidence < b.evidence; });
  const std::string evidence = std::abs(weakest->evidence) < 1000.0
                                   ? fmt::format("{:.3g}", weakest->evidence)
                                   : fmt::format("{:.0f}", weakest->evidence);
  result.headline =
      fmt::format("{:.1f} s of motion; the least evidence that it is expected to give is {}, {} {}.",
                  plan.motion.duration_s(), evidence, weakest->effect,
                  weakest->other.empty() ? std::string("beside the baseline") : "against " + weakest->other);
  result.detail =
      "Evidence is how much the effect is expected to lower the criterion of diagnose, without a unit, if "
      "the axis has it: above 10 it is decisive, below 0 the other would be named. An effect that contains "
      "another can always imitate it.";
  if (known.measurement) {
    result.detail += fmt::format(
        " What the log did is what it has surely done, beyond noise and encoder steps; its {} by the model "
        "is not measured.",
        force_word());
  }
  result.summary = {{"for", request.effects},
                    {"duration_s", plan.motion.duration_s()},
                    {"rate_Hz", plan.motion.rate_Hz},
                    {"low_m", reached.low_m},
                    {"high_m", reached.high_m},
                    {"velocity_mps", reached.velocity_mps},
                    {"acceleration_mps2", reached.acceleration_mps2},
                    {"jerk_mps3", reached.jerk_mps3},
                    {"force_N", plan.peak_force_N},
                    {"limits", std::vector<SummaryEntry>{
                                   {"low_m", limits.low_m},
                                   {"high_m", limits.high_m},
                                   {"velocity_mps", limits.velocity_mps},
                                   {"acceleration_mps2", limits.acceleration_mps2},
                                   {"jerk_mps3", limits.jerk_mps3},
                                   {"force_N", limits.force_N > 0.0 ? limits.force_N : std::nan("")}}}};
  if (known.measurement) {
    result.summary.push_back(
        {"log", std::vector<SummaryEntry>{{"low_m", known.reached.low_m},
                                          {"high_m", known.reached.high_m},
                                          {"velocity_mps", known.reached.velocity_mps},
                                          {"acceleration_mps2", known.reached.acceleration_mps2},
                                          {"jerk_mps3", known.reached.jerk_mps3},
                                          {"force_N", known.reached.force_N}}});
  }
  result.tables = {limits_table(known, limits, reached), evidence_table(plan), pieces_table(plan)};
  std::vector<double> time_s(plan.motion.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) time_s[i] = static_cast<double>(i) / plan.motion.rate_Hz;
  const DisplayUnit length = machine_length_unit();
  result.charts.push_back({"Set points",
                           {"Time", "s", 1.0, false},
                           {"Position", length.label, length.per_si, false},
                           time_s,
                           {{"position", plan.motion.position_m, {}, "measured", false}},
                           false});
  if (request.logs.empty() && request.model.empty()) {
    result.notes.push_back(fmt::format("Assumed: {}; give --log or --model.", assumed_text()));
  }
  for (const ExpectedEvidence& one : plan.expected) {
    if (one.other.empty() && one.evidence < kDecisive) {
      result.notes.push_back(fmt::format(
          "This motion is not expected to decide on {} beside the baseline: evidence {:.3g}, less "
          "than {:g}. Allow more with --limits or --seconds.",
          one.effect, one.evidence, kDecisive));
    }
  }
  result.file =
      to_csv(plan.motion, {"what: set points of slipstack experiment plan", "for: " + request.effects,
                           fmt::format("sample_rate_Hz: {:g}", plan.motion.rate_Hz)});
  return result;
}

}  // namespace slipstack::workbench
