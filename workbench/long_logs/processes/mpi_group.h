// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "workbench/long_logs/processes/process_group.h"

namespace slipstack::workbench {

/// The processes that mpirun (or srun) started together with this one; alone, and without a word to MPI,
/// where none of them started it. Throws InputError, one line, where they started several and this program
/// cannot find the others: it was built without MPI, or for the MPI of another maker.
///
/// A process that waits sleeps: the others may use its processor. One that dies takes all others with it
/// (MPI's error handler, mpirun).
std::unique_ptr<ProcessGroup> join_process_group();

/// Whether this process is the one of those started together that talks to the user; from the environment
/// alone, also where join_process_group() fails.
bool is_first_started();

}  // namespace slipstack::workbench
