// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "workbench/log/import/import_profile.h"

namespace slipstack::workbench {

/// The columns of an export of TwinCAT Scope, by the rows above its numbers; empty where these are no such
/// header. There every row begins with a key, which stands again in each column of times (ms), and the values
/// of the channels behind it: "Name | X.ActPos | Name | X.Force". `rows`: their fields.
std::optional<std::vector<ImportColumn>> scope_columns(const std::vector<std::vector<std::string_view>>& rows,
                                                       std::size_t columns);

}  // namespace slipstack::workbench
