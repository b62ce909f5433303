// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "workbench/long_logs/processes/process_group.h"

namespace slipstack::workbench {

/// The processes that mpirun (or srun) started together with this one; a SingleProcess, without initialising
/// MPI, where the program was started alone. Throws InputError where several were started but this program
/// cannot reach the others: it was built without MPI, or with another implementation of MPI.
///
/// A waiting process sleeps, so that the others may use its processor. When a process dies, all others are
/// ended (MPI's error handler, mpirun).
std::unique_ptr<ProcessGroup> join_process_group();

/// Whether this process is the one of the group that reports to the user. Uses the environment alone, so that
/// it also works where join_process_group() fails.
bool is_first_started();

}  // namespace slipstack::workbench
