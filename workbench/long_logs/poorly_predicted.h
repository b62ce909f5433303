// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/unit_sums.h"

namespace slipstack::workbench {

/// Intervals outside the excerpt, the worst first, in which a model errs by far more than anywhere in the
/// excerpt: the search has not seen what happens there. `windows` holds the errors of the model in the whole
/// logs, `excerpt` the intervals that `measurement` was made of. Each interval found includes its burn-in.
std::vector<LogInterval> poorly_predicted(const std::vector<LongLog>& logs,
                                          const std::vector<Window>& windows,
                                          const std::vector<LogInterval>& excerpt,
                                          const Measurement& measurement);

}  // namespace slipstack::workbench
