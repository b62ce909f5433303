// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "workbench/cli/commands.h"

namespace slipstack::workbench {

/// The commands of `slipstack` and their options, which `options` receives; each runs in its callback
/// (commands.h). Those with files of their own: experiments, simulate, loop, can, bode, manual.
void define_commands(CLI::App& app, Options& options);

}  // namespace slipstack::workbench
