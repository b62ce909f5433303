// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/can/commands/master.h"

namespace slipstack::workbench {

/// What the drive's trace holds.
struct TraceData {
  canopen::TraceHead head;
  std::vector<canopen::TraceSample> samples;
};

/// Waits until an armed trace is full, then reads it by block transfer. Throws UsageError, one line.
TraceData fetch_trace(SdoClient& drive, const Show& show);

}  // namespace slipstack::workbench
