// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "workbench/cleaning/repair.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// A log, or a piece of one.
struct LogChunk {
  Log log;
  std::size_t log_index = 0;     ///< of the log that it is from
  std::size_t first_sample = 0;  ///< within that log
  std::size_t log_samples = 0;   ///< of that log in all
  double log_travel_m = 0.0;     ///< of that log in all
  bool is_whole() const { return log.position_m.size() == log_samples; }
};

/// One log within a measurement of several, or one piece of a long log; they lie one after another: its
/// samples, its rows, its blocks, and what is its own.
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
  double rough_mass_kg = 0.0;  ///< the header's, or a quick regression: good enough to choose the bandwidth
  double log_travel_m = 0.0;   ///< travel of its log in all
  std::size_t burn_in = 0;     ///< samples at its start in which the state of the hysteresis is not known

  std::vector<Interval> cut;          ///< samples, counted from its first, that say nothing
  std::vector<EncoderJump> jumps;     ///< of the encoder, samples counted from its first
  std::vector<std::string> repaired;  ///< what was repaired and cut, one sentence each

  std::size_t end_sample() const { return first_sample + sample_count; }
};

/// Logs put one after another.
struct JoinedLogs {
  Log log;  ///< the header of the first; columns that only some logs have are left out
  std::vector<LogPart> parts;
  std::vector<std::size_t> log_samples;  ///< of each log, whatever part of it is here
};

/// Joins logs of one axis: different loads, places, days. Throws InputError where they do not fit together:
/// another sampling rate, a mass that only some declare, another magnet pitch. Each is repaired
/// (repair.h). Cost: one copy of the samples, none for a single log.
JoinedLogs join(std::vector<Log> logs);
/// The same of pieces, in the order of their logs and of time; each log has one at least.
JoinedLogs join(std::vector<LogChunk> pieces);

/// The part of `values`, one per sample of all logs.
std::vector<double> part_of(const std::vector<double>& values, const LogPart& part);

/// Whether the gains of an effect are each log's own unless the user says otherwise: the mass that was on the
/// carriage, the constant force (tilt, the zero of the sensor), the warming since the axis was started. All
/// else belongs to the axis.
const std::vector<std::string>& effects_of_each_log();

}  // namespace slipstack::workbench
