// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/options.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "workbench/papers/experiment.h"

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

void add_setup(CLI::App& command, SetupChoice& choice, const std::string& otherwise) {
  choice.name = otherwise;
  add_word(command, "--setup", choice.name, "NAME|FILE",
           "set-up: one that ships with slipstack, or a TOML file")
      ->capture_default_str();
}

LengthUnit length_unit(double magnitude_m) {
  const double size = std::fabs(magnitude_m);
  if (size >= 0.1) return {1.0, "m"};
  if (size >= 1e-3) return {1e3, "mm"};
  if (size >= 1e-7) return {1e6, "µm"};
  return {1e9, "nm"};
}

}  // namespace slipstack::workbench
