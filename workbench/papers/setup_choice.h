// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::workbench {

/// --setup: a name or a path.
struct SetupChoice {
  std::string name;

  /// The set-up; throws sim::SetupError when it is not an axis.
  sim::ExperimentSetup axis() const;
  /// The file that no output may replace, if the set-up is read from one.
  std::vector<std::string> inputs() const;
};

}  // namespace slipstack::workbench
