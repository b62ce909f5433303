// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/estimate/measurement/parts.h"
#include "workbench/long_logs/long_log.h"

namespace slipstack::workbench {

/// Logs of up to so many samples together are searched whole.
inline constexpr std::size_t kSearchedWhole = 400000;
/// Approximate number of samples of an excerpt.
inline constexpr std::size_t kExcerptSamples = 131072;

/// An interval of one of several logs: samples [first, first + count).
struct LogInterval {
  std::size_t log = 0;
  std::size_t first = 0;
  std::size_t count = 0;
};

/// All samples of every log where they are few enough to be searched whole, else choose_intervals().
std::vector<LogInterval> searched_intervals(const std::vector<LongLog>& logs);

/// Intervals of long logs that together represent the motion of the logs. Each place on the rail, speed in
/// either direction, acceleration, reversal and part of the time is a kind of motion whose value is the
/// square root of its frequency in the excerpt; the interval that adds most value is chosen next. Each log
/// has at least one interval. An interval is long enough for the axis to cover its pre-sliding travel several
/// times, where it does so at all, and begins with a burn-in of one such travel. About kExcerptSamples in
/// all, ordered by log and time. Depends on the logs alone. Cost: candidates x chosen intervals, from the
/// envelopes only.
std::vector<LogInterval> choose_intervals(const std::vector<LongLog>& logs);

/// The sample at which an interval must begin so that its burn-in ends before `sample`: in between the axis
/// has covered its pre-sliding travel, and oscillations have decayed. At most `longest` samples before.
std::size_t burn_in_start(const LongLog& log, std::size_t sample, std::size_t longest);

/// The intervals of both lists in order; those that overlap or touch are joined.
std::vector<LogInterval> joined(std::vector<LogInterval> intervals, const std::vector<LogInterval>& more);

/// Reads the samples of intervals.
std::vector<LogChunk> chunks_of(const std::vector<LongLog>& logs, const std::vector<LogInterval>& intervals);

}  // namespace slipstack::workbench
