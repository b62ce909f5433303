// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/log/csv/raw_table.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

// A log whose header and columns are in memory already, as those of a file would be read (log.h):
// `table.source` is its name in messages and its path. Throws InputError for columns of unequal lengths, for
// a number that is not finite, and for everything that makes a file unusable. Cost: linear in the samples.
Log log_of_table(RawTable table);

// Throws InputError for columns of unequal lengths and for a number that is not finite.
void require_equal_and_finite(const RawTable& table);

}  // namespace slipstack::workbench
