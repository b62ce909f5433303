// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "workbench/base/errors.h"
#include "workbench/cli/define_experiments.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/papers/define_papers.h"
#include "workbench/plan/known_axis.h"
#include "workbench/plan/limits.h"
#include "workbench/report/plan_result.h"

namespace slipstack::workbench {
namespace {

/// The options of the command line.
struct PlanCommand {
  PlanRequest request;
  ExperimentOutputs outputs;
};

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
    if (known.measurement) {
      known.so_far = expected_evidence(*known.measurement, known.base, plan.effects);
      refuse_less_than_known(known.so_far, plan);
    }
    return plan_result(request, known, limits, plan);
  });
}

}  // namespace

void define_plan(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "plan", "Plan the motion that separates effects, within the limits of the axis");
  auto wanted = std::make_shared<PlanCommand>();
  add_word(*command, "--for", wanted->request.effects, "A,B,..", "effects to show and to separate")
      ->required();
  command
      ->add_option("--log", wanted->request.logs,
                   "logs of the axis: model, noise, and limits where not given")
      ->type_name("FILE...")
      ->expected(1, -1)
      ->take_all();
  CLI::Option* model = add_word(*command, "--model", wanted->request.model, "FILE", "model of the axis");
  add_word(*command, "--effects", wanted->request.baseline, "A,B,..",
           "baseline on the log (default: " + default_baseline_list() + ")")
      ->excludes(model);
  command->add_option("--effect", wanted->request.user_effects, "a user-defined effect that --for names")
      ->type_name("DEFINITION")
      ->allow_extra_args(false)
      ->take_all();
  add_word(*command, "--limits", wanted->request.limits, "K=V,..",
           "stroke=low:high,velocity=,acceleration=,jerk=,force=,current= in SI units (default: each as in "
           "the log)");
  command->add_option("--seconds", wanted->request.seconds, "the motion may last")->capture_default_str();
  command->add_option("--rate", wanted->request.rate_Hz, "set points per second")->capture_default_str();
  add_word(*command, "--out", wanted->outputs.out, "FILE", "set-point file to write, CSV")->required();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_plan(command_line, *wanted); });
}

}  // namespace slipstack::workbench
