// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/commission/stages.h"
#include "workbench/commission/trials.h"
#include "workbench/report/results/experiment_result.h"

namespace slipstack::workbench {

struct CommissionResult {
  std::vector<StageReport> stages;
  std::vector<ModelTrial> trials;
  std::size_t deployed = 0;  ///< index of the trial that the axis runs now
  std::string verdict;       ///< of the diagnosis
  double mass_kg = 0.0;
  double axis_s = 0.0;  ///< that the finished stages took of the axis, in all runs of the command
  std::vector<std::string> notes;
};

/// From an unknown axis to a compensated one:
///
///   prepare     direction, mass, feedback, travel (prepare.h)
///   first look  sines, traverses and moves at two fifths of the limits, then at all of them if those were
///               followed and left room in the force
///   diagnosis   what is missing
///   planned     the experiment that answers what the diagnosis leaves open, once, and the diagnosis again
///   trials      mass alone, then one step of the diagnosis after the other, each kept only where the axis
///               follows better with it (trials.h)
///
/// `search_ends`: where the travel ends is found out, whatever the name plate says of it.
///
/// Each finished stage is in the folder, so that a later call goes on there. Throws
/// CommissionStopped on any fault of the drive and where the axis is unfit; the axis is off then, and a drive
/// that keeps its parameters has those of before. Some two
/// minutes of the axis, some ten seconds of a processor.
CommissionResult commission(LiveAxis& axis, CommissionFolder& folder, Progress& progress,
                            bool search_ends = false);

/// Text, page and JSON of it.
ExperimentResult commission_result(const std::string& axis_title, const CommissionResult& result);

}  // namespace slipstack::workbench
