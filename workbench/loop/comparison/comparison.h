// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim_host/log/draw.h"
#include "workbench/loop/comparison/contenders.h"
#include "workbench/loop/comparison/measures.h"

namespace slipstack::workbench {

/// One contender over all seeds.
struct ComparedContender {
  std::string id;
  std::string title;
  std::string strength;
  bool ours = false;
  bool learns_trajectory = false;
  std::vector<Measures> by_seed;

  /// The share `rank` (0 to 1) of the seeds' values; NaN where none is a number.
  double value(Measure measure, double rank) const;
  double median(Measure measure) const { return value(measure, 0.5); }
};

/// One of the goals of the comparison.
struct ComparedGoal {
  std::string text;
  std::string found;
  bool met = false;
};

struct Comparison {
  std::vector<ComparedContender> contenders;
  std::size_t seeds = 0;
};

/// Tunes the contenders on an axis of each seed, beginning with `first_seed`, and measures them all.
Comparison compare(sim::Setup setup, std::uint64_t first_seed, std::size_t seeds, Field field,
                   const Extent& extent, const std::function<void(const std::string&, double)>& progress);

/// Reversal peak 1/10 of mass feed-forward and 1/2 of the best that learns nothing per trajectory; settling
/// of a 100 mm move 30 % less than with the velocity table; never worse than P/PI alone with a parameter
/// wrong by 30 %. For the plain Maxwell-slip model; by medians, the last by each seed.
std::vector<ComparedGoal> goals_of(const Comparison& comparison);

/// A sentence for each measure in which another is better than each of ours: which, by how much, and why.
std::vector<std::string> lost_cells(const Comparison& comparison);

std::string comparison_text(const Comparison& comparison);
nlohmann::json comparison_json(const Comparison& comparison);

}  // namespace slipstack::workbench
