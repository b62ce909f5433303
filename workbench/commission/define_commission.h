// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace slipstack::workbench {

/// `slipstack commission`. `command_line` must outlive `app`.
void define_commission(CLI::App& app, const std::string& command_line);

}  // namespace slipstack::workbench
