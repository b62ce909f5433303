// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace slipstack::workbench {

/// `slipstack node`, `deploy`, `record`, `status`, `object` and `update`: the controller on a CAN bus.
void define_can(CLI::App& app);

}  // namespace slipstack::workbench
