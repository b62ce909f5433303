// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/define_commands.h"

#include <string>

#include "workbench/base/text.h"
#include "workbench/can/commands/define_bode.h"
#include "workbench/can/commands/define_can.h"
#include "workbench/cli/define_experiments.h"
#include "workbench/cli/define_manual.h"
#include "workbench/cli/define_simulate.h"
#include "workbench/commission/define_commission.h"
#include "workbench/console/positive_number.h"
#include "workbench/estimate/measurement/parts.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/loop/define_loop.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/report/effect_page.h"
#include "workbench/serve/define_serve.h"
#include "workbench/simulate/two_criteria.h"

namespace slipstack::workbench {
namespace {

const auto kNotEmpty = [](const std::string& text) {
  return text.empty() ? std::string("must not be empty") : std::string();
};

/// An option whose value must not be empty: an empty value comes from an unset variable (`--report
/// "$REPORT"`).
CLI::Option* add_text(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description) {
  return command.add_option(name, value, description)->check(kNotEmpty)->type_name(kind);
}

void add_log(CLI::App& command, Options& options) {
  command
      .add_option("LOG", options.logs,
                  "measurement: CSV, or a MAT file (v5 to v7.3); several of one axis are fitted together")
      ->check(kNotEmpty)
      ->type_name("FILE")
      ->expected(1, -1)
      ->required();
  add_text(command, "--per-log", options.per_log, "A,B,..",
           "of several logs: effects with gains of each log's own ('none': all are shared; default: " +
               joined(effects_of_each_log()) + ")");
  command
      .add_option("--noise", options.noise_N,
                  "standard deviation of the force's noise in one sample, N (default: estimated)")
      ->check(positive_number())
      ->type_name("N");
}

void add_outputs(CLI::App& command, Options& options) {
  add_text(command, "--report", options.report, "FILE", "write a report: one HTML page that opens offline");
  add_text(command, "--json", options.json, "FILE", "write the result for machines; '-': standard output");
}

/// User-defined effects; the description has an example that can be typed.
CLI::Option* add_user_effects(CLI::App& command, Options& options, const std::string& description) {
  return command
      .add_option("--effect", options.user_effects,
                  description +
                      ", as 'snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]'; "
                      "may be repeated")
      ->type_name("DEFINITION")
      ->allow_extra_args(false)
      ->take_all();
}

/// The list of effects, below the help of the commands that take their ids.
std::string effect_list() {
  return "Effects:\n" + effect_lines("  ");
}

void run_by(CLI::App& command, const Options& options, decltype(execute_compare)* execute) {
  command.callback([&options, execute] {
    run_command([&](Outputs& outputs, Progress& progress) { return execute(options, outputs, progress); });
  });
}

void define_compare(CLI::App& app, Options& options) {
  CLI::App* compare = app.add_subcommand("compare", "Compare a model with a measurement; nothing is fitted");
  add_log(*compare, options);
  add_text(*compare, "--model", options.model, "FILE", "model file")->required();
  add_outputs(*compare, options);
  run_by(*compare, options, execute_compare);
}

void define_fit(CLI::App& app, Options& options) {
  CLI::App* fit = app.add_subcommand("fit", "Fit a model of chosen effects to a measurement");
  add_log(*fit, options);
  add_text(*fit, "--effects", options.effects, "A,B,..", "effects, separated by commas")->required();
  add_user_effects(*fit, options, "fit also a user-defined effect");
  add_text(*fit, "--model", options.model, "FILE", "model file to write (without: the fit is shown only)");
  CLI::Option* criterion =
      add_text(
          *fit, "--criterion", options.criterion, "force|simulation",
          "what is fitted: the force along the measured motion, or the position that the force alone gives")
          ->check(CLI::IsMember({"force", "simulation"}))
          ->default_val("force");
  fit->add_option("--horizon", options.horizon_s, "duration of the runs of --criterion simulation, s")
      ->check(CLI::Range(0.2, 3600.0))
      ->type_name("S")
      ->default_val(kRunHorizon_s)
      ->needs(criterion);
  add_outputs(*fit, options);
  fit->footer(effect_list());
  run_by(*fit, options, execute_fit);
}

void define_diagnose(CLI::App& app, Options& options) {
  CLI::App* diagnose = app.add_subcommand("diagnose", "Name the physical effect that a model lacks");
  add_log(*diagnose, options);
  CLI::Option* effects =
      add_text(*diagnose, "--effects,--baseline", options.effects, "A,B,..",
               "baseline; auto: chosen by the log (default: " + default_baseline_list() + ")");
  add_text(*diagnose, "--model", options.model, "FILE", "baseline: the effects of this model, fitted again")
      ->excludes(effects);
  add_user_effects(*diagnose, options, "try also a user-defined effect");
  diagnose->add_flag("--stepwise", options.stepwise, "go on until nothing is missing or nothing helps");
  add_outputs(*diagnose, options);
  diagnose->footer(effect_list());
  run_by(*diagnose, options, execute_diagnose);
}

void define_add(CLI::App& app, Options& options) {
  CLI::App* add = app.add_subcommand("add", "Add an effect to a model and fit it again");
  add_log(*add, options);
  add_text(*add, "--model", options.model, "FILE", "model file to start from")->required();
  add_text(*add, "--effect", options.effect, "ID",
           "effect to add; or a user-defined one, as 'name = expression; parameter: unit; ...'")
      ->required();
  add_text(*add, "--out", options.out, "FILE", "model file to write")->required();
  add_outputs(*add, options);
  add->footer(effect_list());
  run_by(*add, options, execute_add);
}

void define_effects(CLI::App& app, Options& options) {
  CLI::App* effects = app.add_subcommand("effects", "Describe the effects of the catalogue");
  add_text(*effects, "ID", options.effect, "ID", "effect to describe; without: list all");
  add_text(*effects, "--pages", options.pages, "FOLDER", "write the reference page of every effect there");
  add_text(*effects, "--header", options.header, "FILE",
           "write the effect that --effect defines as a header for the controller's catalogue");
  add_user_effects(*effects, options, "a user-defined effect")->needs("--header");
  effects->callback([&options] { run_effects(options); });
}

void define_export(CLI::App& app, Options& options) {
  CLI::App* command =
      app.add_subcommand("export", "Write a model as C for any other firmware, simulator or PLC");
  add_text(*command, "MODEL", options.model, "FILE", "model file")->required();
  add_text(*command, "--c", options.c_header, "FILE",
           "C99 header to write, without heap or library; '-': standard output")
      ->required();
  command
      ->add_option("--scalar", options.scalar, "float: what the controller computes; double: for simulators")
      ->check(CLI::IsMember({"float", "double"}))
      ->default_val("float");
  add_text(*command, "--name", options.name, "NAME", "begin of all names in it")->default_val("friction");
  command
      ->add_option(
          "--step", options.step_m,
          "of float: unit of the displacement it is given, as a part of the encoder's step, m or rad "
          "(default: what holds the slip distances)")
      ->check(CLI::Range(1e-12, 1e-2))
      ->type_name("M");
  command
      ->add_option("--rate", options.rate_Hz,
                   "calls per second, for effects that go on from tick to tick, Hz")
      ->check(CLI::Range(1.0, 1e7))
      ->type_name("HZ");
  command->callback([&options] { run_export(options); });
}

}  // namespace

void define_commands(CLI::App& app, Options& options) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "slipstack " SLIPSTACK_VERSION);
  app.footer(
      "`slipstack COMMAND --help` lists the options of a command. Exit status: 0 done, 2 wrong use "
      "or unusable input, 1 internal fault.");
  define_compare(app, options);
  define_fit(app, options);
  define_diagnose(app, options);
  define_add(app, options);
  define_effects(app, options);
  define_export(app, options);
  define_experiment(app, options.command_line);
  define_simulate(app, options.command_line);
  define_loop(app);
  define_commission(app, options.command_line);
  define_can(app);
  define_bode(app, options.command_line);
  define_serve(app, options.group);
  define_manual(app);
}

}  // namespace slipstack::workbench
