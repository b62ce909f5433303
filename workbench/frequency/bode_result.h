// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/frequency/loop_analysis.h"
#include "workbench/frequency/tune.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// `slipstack bode`: margins as a table, the response line by line, Bode and Nyquist charts.
ExperimentResult bode_result(const LoopRecording& recording, const LoopAnalysis& analysis,
                             const std::string& setup);

/// A measurement with the proposed gains in force.
struct TunedLoop {
  DriveController gains;  ///< as the drive holds them
  LoopAnalysis analysis;
};

/// `slipstack tune`: gains and margins as they are, as proposed, and (`tuned` is not null) as measured
/// afterwards.
ExperimentResult tune_result(const LoopRecording& recording, const LoopAnalysis& analysis,
                             const Tuning& tuning, const TuneRequest& request, const TunedLoop* tuned,
                             const std::string& setup);

}  // namespace slipstack::workbench
