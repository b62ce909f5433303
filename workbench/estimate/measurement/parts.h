// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "workbench/cleaning/repair.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// Whether logs of these two sampling rates can be fitted together.
bool is_same_rate(double first_Hz, double other_Hz);

/// A log, or a chunk of one that is too long to be read at once.
struct LogChunk {
  Log log;
  std::size_t log_index = 0;     ///< of the log that it is from
  std::size_t first_sample = 0;  ///< within that log
  std::size_t log_samples = 0;   ///< of that log in all
  double log_travel_m = 0.0;     ///< of that log in all
  bool is_whole() const { return log.position_m.size() == log_samples; }
};

/// One log within a measurement of several, or one chunk of a long log. The parts lie one after another; this
/// is where the samples, rows and blocks of one part are, and its own properties.
struct LogPart {
  std::string path;
  std::size_t log = 0;   ///< index of the log that it is from
  double start_s = 0.0;  ///< time of its first sample since the start of its log
  std::size_t first_sample = 0;
  std::size_t sample_count = 0;
  std::size_t first_row = 0;
  std::size_t row_count = 0;
  int first_block = 0;
  int block_count = 0;
  std::optional<double> mass_kg;
  double encoder_resolution_m = 0.0;
  double force_noise_N = 0.0;  ///< standard deviation before the filter
  double rough_mass_kg = 0.0;  ///< declared, or by a quick regression: enough to choose the bandwidth
  double log_travel_m = 0.0;   ///< travel of its log in all
  std::size_t burn_in = 0;     ///< samples at its start where the state of the hysteresis is unknown

  std::vector<Interval> cut;          ///< intervals without information, samples counted from its first
  std::vector<EncoderJump> jumps;     ///< samples counted from its first
  std::vector<Interval> impacts;      ///< of the drive (Repairs::impacts), samples counted from its first
  std::vector<std::string> repaired;  ///< what was repaired and cut out, one sentence each

  std::size_t end_sample() const { return first_sample + sample_count; }
};

/// The intervals of a part from `from` on that were not cut out; samples counted from its first.
std::vector<Interval> usable_intervals(const LogPart& part, std::size_t from);

/// Logs joined one after another.
struct JoinedLogs {
  Log log;  ///< with the header of the first; columns that only some logs have are left out
  std::vector<LogPart> parts;
  std::vector<std::size_t> log_samples;  ///< of each log, whatever part of it is here
};

/// Joins logs of one axis: different loads, places, days. Throws InputError where they do not fit together:
/// another sampling rate, a mass that only some declare, another magnet pitch. Each is repaired
/// (cleaning/repair.h). Cost: one copy of the samples, none for a single log.
JoinedLogs join(std::vector<Log> logs);
/// The same for chunks, in the order of their logs and of time; each log has at least one.
JoinedLogs join(std::vector<LogChunk> chunks);

/// The part of `values`, one per sample of all logs.
std::vector<double> part_of(const std::vector<double>& values, const LogPart& part);

/// Effects whose gains are fitted for each log separately unless the user says otherwise: the payload, the
/// constant force (tilt, the zero of the sensor), the warming since the axis was started. All others are
/// properties of the axis.
const std::vector<std::string>& effects_of_each_log();

}  // namespace slipstack::workbench
