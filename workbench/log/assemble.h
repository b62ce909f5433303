// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "workbench/log/csv/raw_table.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

// Turns a table into a Log: SI units, force from current, uniform sampling (resampled where the header says
// irregular), encoder resolution. Checks everything that Log promises. Throws InputError.
Log assemble_log(RawTable table);

// Throws InputError where nothing moves, or nothing changes, from end to end of a log; `where` names file and
// column.
void require_motion(const std::string& where, double lowest_m, double highest_m,
                    const std::optional<double>& resolution_m);
void require_force(const std::string& where, double lowest_N, double highest_N);

// Some rows of a longer table, uniformly sampled: checked as far as they can be alone. Without `head` the
// sampling and the encoder's resolution are those that these rows show, with it they are those of `head`.
Log assemble_chunk(RawTable table, const Log* head);

}  // namespace slipstack::workbench
