// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace slipstack::workbench {

/// `slipstack loop`: the controller's tick, here or in an emulated board, around the simulated axis.
void define_loop(CLI::App& app);

}  // namespace slipstack::workbench
