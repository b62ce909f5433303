// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/commands.h"

namespace slipstack::workbench {

void run_command(const std::function<CommandResult(Outputs& outputs, Progress& progress)>& work) {
  Outputs outputs;
  Progress progress;
  const CommandResult result = work(outputs, progress);
  progress.finish();
  outputs.commit(result.text);
}

}  // namespace slipstack::workbench
