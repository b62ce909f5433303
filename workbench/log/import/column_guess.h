// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/log/import/import_profile.h"

namespace slipstack::workbench {

/// The target of a column by its name and unit: known words of English and German, and a unit in brackets,
/// after a slash or at the end. Target empty: nothing known.
ImportColumn guess_column(const std::string& name, const std::string& unit = "");

}  // namespace slipstack::workbench
