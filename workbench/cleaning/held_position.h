// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "workbench/log/log.h"

namespace slipstack::workbench {

/// At which samples a position changes that is recorded at a lower rate than the log has: at every
/// `period`-th from `first` on. A period of 1: at any.
struct PositionUpdates {
  std::size_t period = 1;
  std::size_t first = 0;
};

/// Recognised where nearly all changes of the position are as many samples apart, by several encoder steps,
/// and none is at another place of that period: slow motion of a coarse encoder does not keep to it. O(n).
PositionUpdates updates_of_position(const std::vector<double>& position_m);

/// Keeps only the rows in which such a position is new: between them it is late by up to a period, and its
/// staircase would be accelerations. The log has then a lower rate. Returns a sentence that says so; nothing
/// for any other log, nor where less than Log::kMinimumSamples rows would be left. O(n).
std::optional<std::string> keep_updates_of_position(Log& log);

}  // namespace slipstack::workbench
