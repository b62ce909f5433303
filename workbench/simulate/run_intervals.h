// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/simulate/free_run.h"

namespace slipstack::workbench {

/// Fewest runs of a fit: as many as cross-validation has folds.
inline constexpr std::size_t kLeastRuns = kFolds;

/// The runs by which models are fitted and judged: every part of the measurement without what was cut out of
/// it, from where the memory of its effects is known, in pieces of about `horizon_s` and at least kLeastRuns
/// in all, in the order of time. Throws InputError, which names `logs`, where that leaves runs that are too
/// short.
std::vector<FreeRunInterval> run_intervals(const std::string& logs, const Measurement& measurement,
                                           const Terms& terms, double horizon_s);

/// Runs that follow each other without a gap, joined to one.
std::vector<FreeRunInterval> joined_runs(const std::vector<FreeRunInterval>& runs);

/// Standard deviations of the measured position and velocity at the start of a run: what the low pass of the
/// motion removed from the position, noise and fast motion alike, and its derivative within the bandwidth.
InitialState initial_state_deviation(const Measurement& measurement);

}  // namespace slipstack::workbench
