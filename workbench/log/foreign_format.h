// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace slipstack::workbench {

/// What a file of another program is, and how it becomes a log, by its first bytes (32 are enough): a part of
/// a sentence for an error. Empty where they are none of the formats that are known and not read.
std::string foreign_format(std::string_view head);

}  // namespace slipstack::workbench
