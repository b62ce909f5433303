// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/frequency/loop_analysis.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

/// The size and the phase of the plant over the frequency, with its standard deviation.
void add_plant_charts(ExperimentResult& result, const LoopAnalysis& analysis);

struct NamedLoop {
  std::string name;
  const std::vector<double>* frequency_Hz;
  const std::vector<Complex>* loop;
};

/// Open loop, sensitivity and Nyquist plot of several loops, on the frequencies of the first; a gap where a
/// loop has none. `measured`: beside them the sensitivity that was measured directly.
void add_loop_charts(ExperimentResult& result, const std::vector<NamedLoop>& loops,
                     const LoopAnalysis& analysis, bool measured);

}  // namespace slipstack::workbench
