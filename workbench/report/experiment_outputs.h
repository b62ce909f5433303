// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/console/output.h"
#include "workbench/report/experiment_result.h"

namespace slipstack::workbench {

/// Files that an experiment writes; empty where none is wanted.
struct ExperimentOutputs {
  std::string report;
  std::string json;
  std::string out = "";  ///< a file of the experiment's own kind
};

/// Declares them, before the work. `inputs` are files that none of them may replace. Throws UsageError.
void claim_outputs(const ExperimentOutputs& outputs, const std::vector<std::string>& inputs, Outputs& files);

/// Sets their content, for the caller to commit.
void set_outputs(const ExperimentOutputs& outputs, const ExperimentResult& result,
                 const std::string& command_line, Outputs& files);

}  // namespace slipstack::workbench
