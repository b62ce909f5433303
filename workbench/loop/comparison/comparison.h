// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim_host/log/draw.h"
#include "workbench/loop/comparison/comparison_file.h"
#include "workbench/loop/comparison/contenders.h"
#include "workbench/loop/comparison/measures.h"

namespace slipstack::workbench {

/// One contender over all seeds.
struct ComparedContender {
  ContenderName name;
  std::vector<Measures> by_seed;

  bool is(ContenderName::Kind kind) const { return name.kind == kind; }
  /// The share `rank` (0 to 1) of the seeds' values; NaN where none is a number.
  double value(Measure measure, double rank) const;
  double median(Measure measure) const { return value(measure, 0.5); }
  /// The same of the ratios to another contender on each seed.
  double ratio(Measure measure, double rank, const ComparedContender& other) const;
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
  std::vector<std::string> effects;  ///< of each axis, names with commas; empty where the task has none
};

/// What is compared.
struct ComparisonTask {
  sim::Setup setup = sim::Setup::kPickAndPlace;
  std::uint64_t first_seed = 1;
  std::size_t seeds = 1;
  double encoder_resolution_m = 0.0;  ///< 0: that of the set-up
  /// What each axis has beside mass and hysteresis, in the training too: names, `none`, or `random`, one that
  /// is drawn by its seed.
  std::string effects = "none";
  double strength = 0.0;  ///< of the effects, over the noise floor, rms; 0: six
  Field field = Field::kAll;
  Extent extent;

  bool has_effects() const { return effects != "none"; }
};

/// Tunes the contenders on an axis of each seed and measures them all. An axis that `kept` has is not
/// measured again; what is measured is added to it. About a minute of a processor for an axis, half of it for
/// the iterative learning; a third without Extent::robustness.
Comparison compare(const ComparisonTask& task, ComparisonFile& kept,
                   const std::function<void(const std::string&, double)>& progress);

/// The one with this id; nullptr without one.
const ComparedContender* find(const Comparison& comparison, const std::string& id);

/// Reversal peak 1/10 of mass feed-forward and 1/2 of the best that learns nothing per trajectory; settling
/// of a 100 mm move 30 % less than with the velocity table; never worse than P/PI alone with a parameter
/// wrong by 30 %. For the plain Maxwell-slip model, or as diagnosed where the axes have effects; by medians,
/// the last by each seed. A goal against a peer says too what share of that peer's error the bound is: less
/// than that, no compensator reaches.
std::vector<ComparedGoal> goals_of(const Comparison& comparison);

/// A sentence for each measure in which another is better than each of ours: which, by how much, and why.
std::vector<std::string> lost_cells(const Comparison& comparison);

std::string comparison_text(const Comparison& comparison);
nlohmann::json comparison_json(const Comparison& comparison);

}  // namespace slipstack::workbench
