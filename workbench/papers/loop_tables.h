// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/papers/analysis/loop_log.h"
#include "workbench/papers/analysis/virgin_fit.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

// Tables and charts that `characterize` and `guideway` have in common.

/// Loops of a log, or of a simulation.
struct LoopSeries {
  std::string name;
  std::vector<AveragedLoop> loops;
};

/// The loops of a log that read_log() accepts, ten of each averaged. Throws InputError.
std::vector<AveragedLoop> loops_of_log(const std::string& path);

/// kₑ, cₑω, ζᵣ of every loop, with the closed forms of the rational curve beside them.
ExperimentTable figures_table(const std::vector<LoopSeries>& series, const RationalCurve& curve);

/// Loops, force over position.
ExperimentChart loops_chart(const std::string& title, const std::vector<LoopSeries>& series);

/// ζᵣ over amplitude of every series, and of the closed form.
ExperimentChart damping_chart(const std::vector<LoopSeries>& series, const RationalCurve& curve);

}  // namespace slipstack::workbench
