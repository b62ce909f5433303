// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/define_simulate.h"

#include <memory>

#include "workbench/papers/define_papers.h"

namespace slipstack::workbench {
namespace {

/// The options of the command line.
struct SimulateOptions {
  SimulateRequest request;
  ExperimentOutputs outputs;
};

}  // namespace

void define_simulate(CLI::App& app, const std::string& command_line) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Run a model forward: from a log's force to the position, or from set points to the force");
  auto wanted = std::make_shared<SimulateOptions>();
  SimulateRequest& request = wanted->request;
  add_word(*command, "MODEL", request.model, "FILE", "model file")->required();
  add_word(*command, "--log", request.log, "FILE", "drive the model with the force of this log, open loop");
  add_word(*command, "--setpoints", request.set_points, "FILE",
           "a motion (time_s, position_m): the force that it asks for");
  command
      ->add_option("--start", request.start_s, "where the simulation begins (default: the start of the log)")
      ->type_name("S");
  command->add_option("--end", request.end_s, "where to stop (default: the end of the log)")->type_name("S");
  add_word(*command, "--out", wanted->outputs.out, "FILE", "write the simulated motion or force, CSV");
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] {
    run_command([&](Outputs& outputs, Progress& progress) {
      return execute_simulate(wanted->request, wanted->outputs, command_line, outputs, progress);
    });
  });
}

}  // namespace slipstack::workbench
