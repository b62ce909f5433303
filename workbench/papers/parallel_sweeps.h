// SPDX-License-Identifier: Apache-2.0
// The simulated experiments on several processors: the result does not depend on their number.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <vector>

#include "sim_host/experiments/describing_function.h"
#include "sim_host/experiments/loops.h"
#include "sim_host/experiments/stepped_sine.h"

namespace slipstack::workbench {

/// How a long simulation runs. All members may be left as they are.
struct RunControl {
  std::function<void(double)> progress = {};  ///< share done, 0 … 1; from any thread, one call at a time
  const std::atomic<bool>* stop = nullptr;    ///< when set, a sweep ends before its next point
  std::size_t threads = 0;                    ///< 0: one for each usable processor
};

/// sim::run_stepped_sine() with the force levels at the same time.
void run_sweeps(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request,
                std::vector<sim::SweepChain>& chains, const RunControl& control);

/// sim::run_loops() with the loops at the same time.
std::vector<sim::MeasuredLoop> measure_loops(const sim::ExperimentSetup& setup,
                                             const sim::LoopRequest& request, const RunControl& control);

/// sim::describe_response() at every force and frequency of a request: by force, then by frequency.
std::vector<std::vector<sim::DescribedPoint>> describe_responses(const sim::ExperimentSetup& setup,
                                                                 const sim::SteppedSineRequest& request,
                                                                 const RunControl& control);

}  // namespace slipstack::workbench
