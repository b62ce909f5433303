// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::workbench {

/// What the column "criterion" means, and from which value on the log supports an effect: a line without its
/// capital and its full stop, the same on a terminal, in the report and in the browser.
std::string criterion_note();

}  // namespace slipstack::workbench
