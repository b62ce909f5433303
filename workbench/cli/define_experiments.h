// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace slipstack::workbench {

/// `slipstack experiment`: the experiments of the papers, on simulated set-ups and measured data, and the
/// plan of an experiment of one's own. `command_line` is read when a command runs.
void define_experiment(CLI::App& app, const std::string& command_line);

/// `slipstack experiment plan` (commands/plan_command.cpp).
void define_plan(CLI::App& experiment, const std::string& command_line);

}  // namespace slipstack::workbench
