// SPDX-License-Identifier: Apache-2.0
// A controller moves the simulated axis through the test programme; the run is recorded.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "sim_host/log/record.h"
#include "sim_host/loop/lockstep_board.h"
#include "sim_host/motion/programme.h"
#include "sim_host/plant/axis.h"

namespace slipstack::sim {

struct LoopOptions {
  double tick_s = 1e-4;
  double log_rate_Hz = 2000.0;  ///< at most one sample a tick
  int stream_period_ticks = 20;
  double push_N = 0.0;  ///< constant force on the axis
  std::uint64_t seed = 1;
};

struct LoopResult {
  SimulatedLog log;
  std::int64_t ticks = 0;
  double median_round_trip_s =
      0.0;  ///< of a tick of controller and plant; the median leaves out interruptions by other processes
  double wall_s = 0.0;       ///< duration of the loop, without the start of the board
  double rms_error_m = 0.0;  ///< position error of the reference, while the current was on
  double peak_error_m = 0.0;
  double rms_reversal_error_m = 0.0;  ///< in the 50 ms after each reversal of the reference
  double peak_current_A = 0.0;
  double largest_residual_N = 0.0;
  bool stopped_by_fault = false;  ///< the log ends there
};

/// Sends the parameters that `board`'s link already holds, enables the axis, streams the programme, and
/// records until it is over or the controller reports a fault. `progress` is called with the share done.
/// Throws LoopError when the controller refuses its parameters or cannot be enabled, and when the plant
/// diverges.
LoopResult run_loop(LockstepBoard& board, const Axis& axis, const MotionProgramme& programme,
                    const LoopOptions& options, const std::function<void(double)>& progress);

}  // namespace slipstack::sim
