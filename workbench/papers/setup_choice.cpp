// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/setup_choice.h"

#include <fmt/format.h>

#include <filesystem>

namespace slipstack::workbench {

sim::ExperimentSetup SetupChoice::axis() const {
  sim::ExperimentSetup setup = sim::read_setup(name);
  if (!setup.is_axis()) {
    throw sim::SetupError(fmt::format("{}: has no mass that moves; name a set-up of an axis", name));
  }
  return setup;
}

std::vector<std::string> SetupChoice::inputs() const {
  std::error_code error;
  if (std::filesystem::is_regular_file(name, error)) return {name};
  return {};
}

}  // namespace slipstack::workbench
