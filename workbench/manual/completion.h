// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/manual/command_text.h"

namespace slipstack::workbench {

/// The completion of a program and its commands for bash: commands, options, closed choices, effects (also
/// behind a comma) and files. Sourced, or installed in bash-completion's folder under the name of the
/// program.
std::string bash_completion(const CommandText& program, const std::vector<std::string>& effects);

/// The same for zsh, with the descriptions. Sourced after `compinit`, or installed as `_slipstack` in its
/// `fpath`.
std::string zsh_completion(const CommandText& program, const std::vector<std::string>& effects);

}  // namespace slipstack::workbench
