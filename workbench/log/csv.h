// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/log/byte_source.h"
#include "workbench/log/raw_table.h"

namespace slipstack::workbench {

// Reads `# key: value` lines, one header row and rows of finite numbers, separated by commas; blank lines,
// spaces around fields and comments anywhere are allowed, quotes are not. Names, units and header values are
// checked when the header row is read (columns.h), rows as they come. `name` is how error messages show the
// source. Throws InputError. Linear in the bytes read, never more than one line ahead of the first fault.
RawTable read_csv(const std::string& name, ByteSource& source);

}  // namespace slipstack::workbench
