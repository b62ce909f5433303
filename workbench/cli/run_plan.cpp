// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/cli/define_experiments.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/papers/command_line.h"
#include "workbench/plan/known_axis.h"
#include "workbench/plan/limits.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {
namespace {

/// What the command line says.
struct PlanCommand {
  PlanRequest request;
  ExperimentOutputs outputs;
};

const ExpectedEvidence* find_evidence(const std::vector<ExpectedEvidence>& all,
                                      const ExpectedEvidence& like) {
  for (const ExpectedEvidence& one : all) {
    if (one.effect == like.effect && one.other == like.other) return &one;
  }
  return nullptr;
}

ExperimentTable evidence_table(const Plan& plan, const std::vector<ExpectedEvidence>& so_far) {
  ExperimentTable table{"evidence",
                        "Expected evidence",
                        {{"effect", "effect", ""},
                         {"other", "told from", ""},
                         {"log_angle_deg", "angle, log", "deg", 1.0, 3},
                         {"angle_deg", "angle, plan", "deg", 1.0, 3},
                         {"log_evidence", "evidence, log", "", 1.0, 3},
                         {"evidence", "evidence, plan", "", 1.0, 3}},
                        {}};
  const double none = std::nan("");
  for (const ExpectedEvidence& one : plan.expected) {
    const ExpectedEvidence* log = find_evidence(so_far, one);
    table.rows.push_back({one.effect, one.other.empty() ? std::string("nothing") : one.other,
                          log == nullptr ? none : log->angle_deg, one.angle_deg,
                          log == nullptr ? none : log->evidence, one.evidence});
  }
  return table;
}

ExperimentTable pieces_table(const Plan& plan) {
  ExperimentTable table{"pieces", "The motion", {{"piece", "#", "", 1.0, 0}, {"what", "what", ""}}, {}};
  for (std::size_t i = 0; i < plan.pieces.size(); ++i) {
    table.rows.push_back({static_cast<double>(i + 1), plan.pieces[i]});
  }
  return table;
}

ExperimentResult plan_result(const PlanRequest& request, const KnownAxis& known, const AxisLimits& limits,
                             const Plan& plan) {
  const AxisLimits reached = extremes_of(plan.motion);
  ExperimentResult result;
  result.experiment = "plan";
  result.setup = request.logs.empty()
                     ? request.model.empty() ? "an axis of which only the limits are known" : request.model
                     : joined(request.logs);
  const auto weakest = std::min_element(plan.expected.begin(), plan.expected.end(),
                                        [](const auto& a, const auto& b) { return a.evidence < b.evidence; });
  result.headline =
      fmt::format("{:.1f} s of motion; the least evidence that it is expected to give is {:.3g}, {} {}.",
                  plan.motion.duration_s(), weakest->evidence, weakest->effect,
                  weakest->other.empty() ? std::string("beside the baseline") : "against " + weakest->other);
  result.detail =
      "Evidence is the expected difference of BIC if the axis has the effect: above 10 it is decisive, below "
      "0 the other would be named. An effect that contains another can always imitate it.";
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
  result.tables = {evidence_table(plan, known.so_far), pieces_table(plan)};
  std::vector<double> time_s(plan.motion.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) time_s[i] = static_cast<double>(i) / plan.motion.rate_Hz;
  result.charts.push_back({"Set points",
                           {"Time", "s", 1.0, false},
                           {"Position", "mm", 1e3, false},
                           time_s,
                           {{"position", plan.motion.position_m, {}, "measured", false}},
                           false});
  result.notes.push_back(fmt::format("Reached: {} to {}, {}, {:.3g} m/s2, {:.3g} m/s3, {} by the model.",
                                     quantity(reached.low_m, "m"), quantity(reached.high_m, "m"),
                                     quantity(reached.velocity_mps, "m/s"), reached.acceleration_mps2,
                                     reached.jerk_mps3, newtons(plan.peak_force_N)));
  if (request.logs.empty() && request.model.empty()) {
    result.notes.push_back(fmt::format("Assumed: {}; give --log or --model.", assumed_text()));
  }
  result.file =
      to_csv(plan.motion, {"what: set points of slipstack experiment plan", "for: " + request.effects,
                           fmt::format("sample_rate_Hz: {:g}", plan.motion.rate_Hz)});
  return result;
}

void run_plan(const std::string& command_line, const PlanCommand& command) {
  const PlanRequest& request = command.request;
  declare_effects(request.user_effects);
  const std::vector<std::string> ids = parse_effects(request.effects);
  for (const std::string& id : ids) {
    if (!find_effect(id)->is_plannable()) {
      throw UsageError(fmt::format("--for: no experiment can be planned for {}; name another effect", id));
    }
  }
  if (!(request.seconds >= 5.0 && request.seconds <= 3600.0))
    throw UsageError("--seconds: must be between 5 and 3600");
  if (!(request.rate_Hz >= 200.0 && request.rate_Hz <= 20000.0)) {
    throw UsageError("--rate: must be between 200 and 20000 Hz");
  }
  const GivenLimits given = parse_limits(request.limits);
  std::vector<std::string> inputs = request.logs;
  inputs.push_back(request.model);
  run_experiment(command_line, command.outputs, inputs, [&](Progress& progress) {
    AxisLimits limits;
    if (request.logs.empty()) limits = limits_of_axis(given);
    KnownAxis known = known_axis(request, ids, progress);
    if (known.measurement) {
      limits = limits_of_axis(given, known.reached, known.measurement->log().motor_constant_N_per_A);
    }
    const Plan plan = plan_experiment(
        known.knowledge, {limits, request.seconds, [&](const std::string& stage, double fraction) {
                            progress.show(stage, fraction);
                          }});
    if (known.measurement) known.so_far = expected_evidence(*known.measurement, known.base, plan.effects);
    return plan_result(request, known, limits, plan);
  });
}

}  // namespace

void define_plan(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "plan", "Plan the motion that tells effects apart, within the limits of the axis");
  auto wanted = std::make_shared<PlanCommand>();
  add_word(*command, "--for", wanted->request.effects, "A,B,..", "effects to show and to tell apart")
      ->required();
  command
      ->add_option("--log", wanted->request.logs,
                   "what is known so far: model, noise, and limits where not given; several of one axis")
      ->type_name("FILE...")
      ->expected(1, -1)
      ->take_all();
  CLI::Option* model = add_word(*command, "--model", wanted->request.model, "FILE", "model of the axis");
  add_word(*command, "--effects", wanted->request.baseline, "A,B,..",
           "baseline on the log (default: " + default_baseline_list() + ")")
      ->excludes(model);
  command->add_option("--effect", wanted->request.user_effects, "an effect of your own that --for names")
      ->type_name("DEFINITION")
      ->allow_extra_args(false)
      ->take_all();
  add_word(*command, "--limits", wanted->request.limits, "K=V,..",
           "stroke=low:high,velocity=,acceleration=,jerk=,force=,current= in SI units (default: the log's "
           "motion; no force)");
  command->add_option("--seconds", wanted->request.seconds, "the motion may last")->capture_default_str();
  command->add_option("--rate", wanted->request.rate_Hz, "set points per second")->capture_default_str();
  add_word(*command, "--out", wanted->outputs.out, "FILE", "set-point file to write, CSV")->required();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_plan(command_line, *wanted); });
}

}  // namespace slipstack::workbench
