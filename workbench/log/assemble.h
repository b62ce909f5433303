// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "workbench/log/csv/raw_table.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

// Turns a table into a Log: SI units, force from current, uniform sampling (resampled where the header says
// irregular), encoder resolution. Checks everything that log.h guarantees. Throws InputError.
Log assemble_log(RawTable table);

// Throw InputError where the position, or the force, is the same in all of a log; `where` names file and
// column.
void require_motion(const std::string& where, double lowest_m, double highest_m,
                    const std::optional<double>& resolution_m);
void require_force(const std::string& where, double lowest_N, double highest_N);

// "encoder_resolution_m is not in the header; the positions move in steps of 1e-06 m".
std::string estimated_resolution_note(double resolution_m);

// A chunk of the rows of a longer, uniformly sampled table; checks what can be checked on the chunk alone.
// Sampling and encoder resolution are those of `head`, or without it are estimated from these rows.
Log assemble_chunk(RawTable table, const Log* head);

}  // namespace slipstack::workbench
