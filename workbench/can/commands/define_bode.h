// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace slipstack::workbench {

/// `slipstack bode` and `slipstack tune`. `command_line`: as typed, for the report.
void define_bode(CLI::App& app, const std::string& command_line);

}  // namespace slipstack::workbench
