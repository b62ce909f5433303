// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/log/log.h"
#include "workbench/log/raw_table.h"

namespace slipstack::workbench {

// Turns a table into a Log: SI units, force from current, uniform sampling (resampled where the header says
// irregular), encoder resolution. Checks everything that Log promises. Throws InputError.
Log assemble_log(RawTable table);

}  // namespace slipstack::workbench
