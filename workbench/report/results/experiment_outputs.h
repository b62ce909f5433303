// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::workbench {

/// Files that an experiment writes; empty where none is wanted.
struct ExperimentOutputs {
  std::string report;
  std::string json;
  std::string out = "";  ///< a file of the experiment's own kind
};

}  // namespace slipstack::workbench
