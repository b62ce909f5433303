// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace slipstack::workbench {

/// Breaks lines longer than `width` characters (UTF-8) between words. Continuation lines are indented to the
/// column at which the text of the line begins ("noise      ..."). Lines that begin with two spaces are
/// commands to be copied and are not broken.
std::string wrapped(std::string_view text, std::size_t width);

/// Width of the terminal that standard output is connected to, in columns; 0 where it is not a terminal (then
/// nothing is wrapped).
std::size_t terminal_width();

}  // namespace slipstack::workbench
