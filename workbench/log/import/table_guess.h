// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "workbench/log/import/import_profile.h"

namespace slipstack::workbench {

/// Separator, decimal mark, row of names, units and columns of a table of text, from its first lines; empty
/// where it is no table of numbers.
std::optional<ImportProfile> guess_table(std::string_view text);

}  // namespace slipstack::workbench
