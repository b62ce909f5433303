// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/define_experiments.h"

#include <fmt/format.h>

#include <memory>

#include "sim_host/experiments/setup.h"
#include "sim_host/experiments/setup_files.h"
#include "workbench/base/errors.h"
#include "workbench/console/output.h"
#include "workbench/papers/define_papers.h"

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
      experiment.add_subcommand("setup", "Print the file of a set-up, as a start for a set-up of yours");
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

void define_experiment(CLI::App& app, const std::string& command_line) {
  CLI::App* experiment =
      app.add_subcommand("experiment", "Run an experiment of the papers, simulated or on data");
  experiment->require_subcommand(1);
  define_setup(*experiment);
  define_experiments_of_papers(*experiment, command_line);
  define_plan(*experiment, command_line);
  experiment->footer(setup_list());
}

}  // namespace slipstack::workbench
