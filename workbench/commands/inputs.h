// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/commands/command.h"
#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {

// From options to inputs. All functions throw UsageError or InputError.

/// Declares the logs that are files as inputs, which no output may replace.
void spare_logs(const CommandOptions& options, Outputs& outputs);

/// The same for the model that is read.
void spare_model(const CommandOptions& options, Outputs& outputs);

/// The logs and how they are conditioned.
LogRequest log_request(const CommandOptions& options);

/// Names of the logs, separated by ", ".
std::string log_names(const CommandOptions& options);

/// The model that is read.
Model model_of(const CommandOptions& options);

}  // namespace slipstack::workbench
