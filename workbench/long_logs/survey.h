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

/// Rows of a file between two places at which reading can start.
inline constexpr std::size_t kRowsPerPlace = 32768;

/// The result of reading a long CSV file once, small enough to be kept and sent to other processes: 12 bytes
/// for kEnvelopeSamples samples, at most 13 MB, and 16 bytes for kRowsPerPlace samples.
struct Survey {
  Log head;  ///< without samples
  std::size_t samples = 0;
  Envelope envelope;
  double travel_m = 0.0;
  RawTable table;  ///< header and column names
  std::vector<LineReader::Place> places;
  std::size_t bytes = 0;  ///< of the file
};

/// Whether a file is CSV text that is sampled uniformly, so that chunks of it can be read separately. Throws
/// InputError where its header cannot be used.
bool reads_in_chunks(const std::string& name, const InputFile& file);

/// Reads a file from end to end in chunks of kRowsPerPlace rows and checks all that read_log() checks. Throws
/// InputError. Cost: that of read_log(), with the memory of one chunk.
Survey survey(const std::string& name, const InputFile& file);

/// Converts a survey to bytes, for a process that does not read the file itself, and back.
std::string to_bytes(const Survey& survey);
Survey survey_of(const std::string& bytes);

}  // namespace slipstack::workbench
