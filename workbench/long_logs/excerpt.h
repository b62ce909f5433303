// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/estimate/measurement/parts.h"
#include "workbench/long_logs/long_log.h"

namespace slipstack::workbench {

/// Up to so many samples, of all logs together, are searched whole.
inline constexpr std::size_t kSearchedWhole = 400000;
/// Samples of the excerpt of more.
inline constexpr std::size_t kExcerptSamples = 131072;

/// A stretch of one of several logs.
struct LogInterval {
  std::size_t log = 0;
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Every log from end to end where they are short enough to be searched whole, or choose_intervals().
std::vector<LogInterval> searched_intervals(const std::vector<LongLog>& logs);

/// Stretches of long logs that together show what the logs show: each place of the rail, speed either way,
/// acceleration, reversal and part of the time counts by the root of how often it is seen, and the stretch
/// that adds most comes first. Each log has one at least; a stretch is long enough for the axis to sweep its
/// pre-sliding travel several times over, where it ever does, and begins one such sweep before what it is
/// chosen for. About kExcerptSamples in all, in the order of
/// the logs and of time. Depends on the logs alone. Cost: stretches x chosen, from glances only.
std::vector<LogInterval> choose_intervals(const std::vector<LongLog>& logs);

/// Where a stretch must begin so that the state is known at `sample`: the axis has swept its pre-sliding
/// travel in between, and what swings has settled. At most `most` samples before.
std::size_t lead_in(const LongLog& log, std::size_t sample, std::size_t most);

/// Both, in order; what overlaps or touches is one.
std::vector<LogInterval> joined(std::vector<LogInterval> intervals, const std::vector<LogInterval>& more);

/// The samples of stretches.
std::vector<LogChunk> chunks_of(const std::vector<LongLog>& logs, const std::vector<LogInterval>& intervals);

}  // namespace slipstack::workbench
