// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/can/commands/master.h"
#include "workbench/frequency/record_file.h"

namespace slipstack::workbench {

/// How the loop is excited and recorded.
struct LoopMeasurement {
  double lowest_Hz = 4.0;
  double highest_Hz = 0.0;    ///< 0: 0.15 of the tick's rate
  bool at_force = true;       ///< else the position reference is changed
  double amplitude_A = 0.0;   ///< of the highest band; 0: a tenth of the current limit
  double deviation_m = 1e-3;  ///< at which the drive ends the excitation
  double velocity_mps = 0.0;  ///< at which the axis moves meanwhile, to and fro; below 0: backwards first
  int captures = 4;           ///< per band, of four periods each
};

/// Excites the loop of an enabled drive in profile position or profile velocity mode (2320h) and reads its
/// trace, band after band: periods of 1024 ticks for what is above 80 Hz at a tick of 10 kHz, then ten times
/// as long for the decade below, and so on. The first period of each capture, in which the transient decays,
/// is left out. At a velocity each capture is a move of its own, in profile velocity a time at it. A change
/// of the reference is as large as makes the current of the amplitude by Kp Kv. The lower bands get as much
/// amplitude as moves the axis by 0.1 mm at most, by Kp Kv.
///
/// Throws UsageError, one line, when the drive is not enabled, refuses, or ends the excitation by itself. The
/// excitation is stopped then.
LoopRecording measure_loop(SdoClient& drive, const LoopMeasurement& wanted, const Show& show);

}  // namespace slipstack::workbench
