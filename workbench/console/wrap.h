// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace slipstack::workbench {

/// Lines longer than `width` characters (UTF-8) broken between words, what follows under the column that the
/// line began its text in ("noise      ..."). Lines that begin with two spaces are commands to copy and stay.
std::string wrapped(std::string_view text, std::size_t width);

/// Columns of the terminal that standard output is; 0 where it is none (then nothing is wrapped).
std::size_t terminal_width();

}  // namespace slipstack::workbench
