// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"
#include "workbench/report/results/addition_result.h"

namespace slipstack::workbench {

/// The work of `slipstack add`: the model with one more effect, fitted again. `log`: names of the logs. The
/// result lacks `command_line` and `model_path`. Throws UsageError and InputError for an effect that these
/// logs cannot determine.
AdditionResult add_effect(LogSearch& logs, const std::string& log, const Model& old,
                          const EffectDescription& effect, Progress& progress);

}  // namespace slipstack::workbench
