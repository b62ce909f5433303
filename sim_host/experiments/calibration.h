// SPDX-License-Identifier: Apache-2.0
// A simulated calibration of a force transducer in load steps ([3]).
#pragma once

#include <cstdint>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

/// One reading, taken when the signal has settled.
struct LoadStep {
  double time_s = 0.0;
  double load_N = 0.0;
  double signal_mV_per_V = 0.0;
};

/// A calibration of the set-up's transducer after [3]: 200 elements, linearity deviation, drift with time,
/// noise. `virgin`: one cycle in even steps without preloads, of a transducer that has not been loaded
/// before. `loops`: preloads, then the cycle with a loop between 22 and 8 % of full scale on both ways, in
/// steps of 2 % ([3], section 6). `repeat`: the same once more. The three records follow one another: each
/// begins in the state in which the one before ended.
struct SimulatedCalibration {
  std::vector<LoadStep> virgin;
  std::vector<LoadStep> loops;
  std::vector<LoadStep> repeat;
};
SimulatedCalibration simulate_calibration(const TransducerSetup& setup, std::uint64_t seed);

}  // namespace slipstack::sim
