// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/can/commands/measure_loop.h"
#include "workbench/frequency/bode_result.h"

namespace slipstack::workbench {

/// A proposal; throws UsageError when no gains keep the margin.
Tuning propose_or_refuse(const LoopRecording& recording, const LoopAnalysis& analysis,
                         const TuneRequest& request);

struct TunedDrive {
  Tuning tuning;
  TunedLoop loop;  ///< measured with the gains in force
};

/// Proposes gains by what was measured, puts them into the drive, measures again, and stores them if asked.
/// The axis decides: while the measured margin is more than two standard deviations below the wanted one,
/// what was measured now is what the next proposal is made of, with as much more margin; three times at most.
/// When that does not reach it, or the axis does not stay enabled, the gains of before are put back and
/// UsageError thrown.
TunedDrive tune_drive(SdoClient& drive, const LoopRecording& recording, const LoopAnalysis& analysis,
                      const LoopMeasurement& measurement, const TuneRequest& request, bool store,
                      const Show& show);

}  // namespace slipstack::workbench
