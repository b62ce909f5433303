// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): the name is CLI11's
class App;
}  // namespace CLI

namespace slipstack::workbench {

class ProcessGroup;

/// Adds `serve` and `import`. `group` is read when a command runs.
void define_serve(CLI::App& app, ProcessGroup* const& group);

}  // namespace slipstack::workbench
