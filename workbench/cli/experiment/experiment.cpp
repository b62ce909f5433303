// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/experiment/experiment.h"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "sim_host/experiments/setup.h"
#include "sim_host/experiments/setup_files.h"
#include "workbench/cli/results.h"
#include "workbench/log/log.h"
#include "workbench/log/text.h"
#include "workbench/report/html.h"

namespace slipstack::workbench {
namespace {

/// The set-ups, below the help of every experiment.
std::string setup_list() {
  std::string list = "Set-ups (or the path of a TOML file; docs/experiments.md):\n";
  for (const sim::SetupFile& file : sim::setup_files()) {
    const std::string name(file.name);
    list += fmt::format("  {:<22} {}\n", name, sim::read_setup(name).title);
  }
  return list;
}

void define_setup(CLI::App& experiment) {
  CLI::App* command =
      experiment.add_subcommand("setup", "Print the file of a set-up, to start one of your own");
  auto name = std::make_shared<std::string>();
  add_word(*command, "NAME", *name, "NAME", "a set-up of the list below")->required();
  command->callback([name] {
    try {
      Outputs().commit(sim::setup_text(*name));
    } catch (const sim::SetupError& error) {
      throw UsageError(error.what());
    }
  });
}

}  // namespace

CLI::Option* add_word(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description) {
  const auto not_empty = [](const std::string& text) {
    return text.empty() ? std::string("must not be empty") : std::string();
  };
  return command.add_option(name, value, description)->check(not_empty)->type_name(kind);
}

void add_experiment_outputs(CLI::App& command, ExperimentOutputs& outputs) {
  add_word(command, "--report", outputs.report, "FILE", "write a report: one HTML page that opens offline");
  add_word(command, "--json", outputs.json, "FILE", "write the result for machines; '-': standard output");
}

void said_of(const std::string& where, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}", printable(where), error.what()));
  }
}

void deliver(const Options& options, const ExperimentOutputs& outputs, const std::vector<std::string>& inputs,
             const std::function<ExperimentResult(Progress&)>& work) {
  Outputs files;
  for (const std::string& input : inputs) files.spare(input);
  files.claim(outputs.report);
  files.claim(outputs.json);
  files.claim(outputs.out);
  Progress progress;
  ExperimentResult result;
  try {
    result = work(progress);
  } catch (const sim::SetupError& error) {
    throw UsageError(error.what());
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  files.set(outputs.json, json_text(result_json(result)));
  files.set(outputs.out, result.file);
  if (!outputs.report.empty()) {
    files.set(outputs.report, render_report(result_report(result, options.command_line)));
  }
  progress.finish();
  files.commit(result_text(result));
}

void define_experiment(CLI::App& app, const Options& options) {
  CLI::App* experiment =
      app.add_subcommand("experiment", "Run an experiment of the papers, simulated or on data");
  experiment->require_subcommand(1);
  define_setup(*experiment);
  define_loops(*experiment, options);
  define_step(*experiment, options);
  define_free(*experiment, options);
  define_characterize(*experiment, options);
  define_guideway(*experiment, options);
  define_transducer(*experiment, options);
  define_stepped_sine(*experiment, options);
  define_describing_function(*experiment, options);
  define_sensitivity(*experiment, options);
  define_models(*experiment, options);
  define_plan(*experiment, options);
  experiment->footer(setup_list());
}

}  // namespace slipstack::workbench
