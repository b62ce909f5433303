// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "sim_host/loop/lockstep_board.h"
#include "sim_host/plant/axis.h"
#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// The machine that a drive in lock-step moves.
struct LockstepMachine {
  sim::Axis axis;
  std::uint64_t seed = 1;       ///< of the amplifier's noise
  bool motor_reversed = false;  ///< its wires
  double end_m = 0.0;           ///< a stop that shortens the travel; 0: none
};

/// An axis of the simulator behind a controller in lock-step, on any board: at rest in the middle of its
/// travel. The drive knows no more of it than its name plate. Throws std::invalid_argument on an unphysical
/// axis.
std::unique_ptr<LiveAxis> lockstep_axis(std::unique_ptr<sim::LockstepBoard> board,
                                        const LockstepMachine& machine);

}  // namespace slipstack::workbench
