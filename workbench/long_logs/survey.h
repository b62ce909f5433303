// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "workbench/log/csv/line_reader.h"
#include "workbench/log/csv/raw_table.h"
#include "workbench/log/input_file.h"
#include "workbench/log/log.h"
#include "workbench/long_logs/envelope.h"

namespace slipstack::workbench {

/// Rows of a file between places at which reading may go on.
inline constexpr std::size_t kRowsPerPlace = 32768;

/// What one reading of a long CSV file tells of it, small enough to be kept and to be told to others: 12
/// bytes for kGlanceSamples samples, 13 MB at most, and 16 for kRowsPerPlace.
struct Survey {
  Log head;  ///< without samples
  std::size_t samples = 0;
  Envelope envelope;
  double travel_m = 0.0;
  RawTable table;  ///< header and column names
  std::vector<LineReader::Place> places;
  std::size_t bytes = 0;  ///< of the file
};

/// Whether a file is CSV text, sampled uniformly, so that pieces of it can be read on their own. Throws
/// InputError where its beginning cannot be used.
bool reads_in_chunks(const std::string& name, const InputFile& file);

/// Reads a file from end to end, a stretch of rows at a time, and checks all that read_log() checks. Throws
/// InputError. Cost: that of read_log(), with the memory of one stretch.
Survey survey(const std::string& name, const InputFile& file);

/// The survey as bytes, for a process that does not read the file itself, and back.
std::string to_bytes(const Survey& survey);
Survey survey_of(const std::string& bytes);

}  // namespace slipstack::workbench
