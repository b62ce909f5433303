// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "workbench/log/log.h"
#include "workbench/long_logs/survey.h"

namespace slipstack::workbench {

/// A log of any length, read in chunks: a short one is held in memory; a long CSV file is read again from the
/// byte at which a chunk begins. Memory: that of the samples of at most 64 MiB of text, or that of the
/// survey.
class LongLog {
 public:
  static constexpr std::size_t kInMemoryBytes = std::size_t{64} << 20;

  /// Reads the log once from end to end and checks all that read_log() checks. `in_memory_bytes`: files up to
  /// this size are held in memory; others too where they are no CSV text or sampled irregularly. Throws
  /// InputError.
  static LongLog open(const std::filesystem::path& path, std::size_t in_memory_bytes = kInMemoryBytes);

  /// A log that is in memory already, as read_log() leaves it.
  static LongLog held(Log log);
  /// A log that another process has surveyed: nothing is read yet. Throws InputError where the file is not
  /// the one that was surveyed.
  static LongLog open(const std::filesystem::path& path, Survey survey);
  /// Whether open() would leave the log in its file.
  static bool stays_in_file(const std::filesystem::path& path, std::size_t in_memory_bytes);
  /// The survey of a log that stays in its file; nullptr where the log is held in memory.
  const Survey* survey() const;

  /// Everything but the samples.
  const Log& head() const;
  std::size_t sample_count() const;
  /// The highest position minus the lowest.
  double travel_m() const;
  const Envelope& envelope() const;

  /// Samples [first, first + count), which must exist; start_time_s is the time of the first of them. May be
  /// called from several threads. Throws InputError where the file has changed since open().
  Log chunk(std::size_t first, std::size_t count) const;

 private:
  struct State;
  explicit LongLog(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace slipstack::workbench
