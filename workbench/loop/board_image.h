// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::workbench {

/// The firmware image of an emulated board: `image` if it is named, else the one beside the program, where an
/// installation puts it, or where the cortex-m4 preset builds it. The file may be missing.
std::string board_image(const std::string& board, const std::string& image);

}  // namespace slipstack::workbench
