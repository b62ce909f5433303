// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "workbench/cli/commands.h"

namespace slipstack::workbench {

/// `slipstack simulate`: a model run forward, from a log's force to the position, or from set points to the
/// force.
void define_simulate(CLI::App& app, const std::string& command_line);

}  // namespace slipstack::workbench
