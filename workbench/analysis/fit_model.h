// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/long_logs/log_search.h"
#include "workbench/report/results/fit_result.h"

namespace slipstack::workbench {

struct FitRequest {
  std::string log;                   ///< names of the logs, separated by ", "
  std::vector<std::string> effects;  ///< ids
  bool by_simulation = false;        ///< the position that the force alone gives, not the force
  double horizon_s = 0.0;            ///< of the runs of the latter
};

/// The work of `slipstack fit`. The result lacks `command_line` and `model_path`. Throws UsageError and
/// InputError for effects that these logs cannot determine.
FitResult fit_model(LogSearch& logs, const FitRequest& request, Progress& progress);

}  // namespace slipstack::workbench
