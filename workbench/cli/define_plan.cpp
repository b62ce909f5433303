// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "workbench/cli/commands.h"
#include "workbench/cli/define_experiments.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/papers/define_papers.h"

namespace slipstack::workbench {
namespace {

/// The options of the command line.
struct PlanCommand {
  PlanRequest request;
  ExperimentOutputs outputs;
};

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
  command->add_option("--seconds", wanted->request.seconds,
                      "the motion may last (default: 60; where the log shows more, up to twice the log)");
  command->add_option("--rate", wanted->request.rate_Hz, "set points per second")->capture_default_str();
  add_word(*command, "--out", wanted->outputs.out, "FILE", "set-point file to write, CSV")->required();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] {
    run_command([&](Outputs& outputs, Progress& progress) {
      return execute_plan(wanted->request, wanted->outputs, command_line, outputs, progress);
    });
  });
}

}  // namespace slipstack::workbench
