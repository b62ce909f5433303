// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/cli/commands.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/long_logs/log_search.h"

namespace slipstack::workbench {

// What the commands make of their arguments. All of these throw UsageError or InputError.

/// The logs are inputs: no output may take the place of one.
void spare_logs(const Options& options, Outputs& outputs);

/// What the command line says of the logs.
LogRequest log_request(const Options& options);

}  // namespace slipstack::workbench
