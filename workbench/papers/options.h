// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::workbench {

// What the command lines of the experiments have in common.

/// --setup: a name or a path.
struct SetupChoice {
  std::string name;

  /// The set-up; throws sim::SetupError when it is not an axis.
  sim::ExperimentSetup axis() const;
  /// The file to spare, when it is one.
  std::vector<std::string> inputs() const;
};
void add_setup(CLI::App& command, SetupChoice& choice, const std::string& otherwise);

/// A unit in which a length of this size reads well.
struct LengthUnit {
  double per_m;
  std::string label;
};
LengthUnit length_unit(double magnitude_m);

}  // namespace slipstack::workbench
