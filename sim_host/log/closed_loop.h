// SPDX-License-Identifier: Apache-2.0
// A log of an axis under closed-loop control.
#pragma once

#include <cstdint>

#include "sim_host/log/record.h"

namespace slipstack::sim {

/// The axis follows `programme` under a cascade controller (at a multiple of the log's rate, 5 kHz or more;
/// velocity bandwidth drawn from the seed, 25 to 50 Hz), with following errors and with limit cycles where
/// friction causes them. The force channel is the current command × nominal motor constant; the force noise
/// is the amplifier's: it moves the axis but is not part of the command, so `noise_N` holds its negative.
/// Cost: about 1 µs per logged sample. Throws std::runtime_error when the control loop becomes unstable.
SimulatedLog simulate_closed_loop_log(const Axis& axis, const MotionProgramme& programme, double rate_Hz,
                                      std::uint64_t seed, bool keep_parts = false);

}  // namespace slipstack::sim
