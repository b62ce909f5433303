// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/cli/commands.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/long_logs/log_search.h"

namespace slipstack::workbench {

// From options to inputs. All functions throw UsageError or InputError.

/// Declares the logs as inputs, which no output may replace.
void spare_logs(const Options& options, Outputs& outputs);

/// The logs and how they are conditioned, by the command line.
LogRequest log_request(const Options& options);

}  // namespace slipstack::workbench
