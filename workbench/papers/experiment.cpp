// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/experiment.h"

#include <fmt/format.h>

#include <stdexcept>

#include "sim_host/experiments/setup.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/commands/experiment_command.h"
#include "workbench/console/output.h"

namespace slipstack::workbench {

Log read_guideway_log(const std::string& path) {
  Log log = read_log(path);
  if (axis_is_rotary()) {
    throw InputError(printable(path) +
                     ": is of a rotary axis; the experiments of the papers are on guideways, give a log with "
                     "position_m and force_N");
  }
  return log;
}

void prefix_errors(const std::string& source, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}", printable(source), error.what()));
  }
}

void run_experiment(const std::string& command_line, const ExperimentOutputs& outputs,
                    const std::vector<std::string>& inputs,
                    const std::function<ExperimentResult(Progress&)>& work) {
  Outputs files;
  Progress progress;
  const CommandResult given = execute_experiment(outputs, inputs, command_line, files, [&] {
    try {
      return work(progress);
    } catch (const sim::SetupError& error) {
      throw UsageError(error.what());
    }
  });
  progress.finish();
  files.commit(given.text);
}

}  // namespace slipstack::workbench
