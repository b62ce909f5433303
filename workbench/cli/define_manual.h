// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace slipstack::workbench {

/// `slipstack completion` and `slipstack manual`: what a shell and man know of `app`, and of slipstack-sim.
/// Both are written from the definitions that --help prints; `app` must outlive the command.
void define_manual(CLI::App& app);

}  // namespace slipstack::workbench
