// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/long_log.h"
#include "workbench/long_logs/processes/process_group.h"
#include "workbench/long_logs/whole_logs.h"

namespace slipstack::workbench {

/// Logs that are in memory and in no file, by the names that stand for their paths.
using LogsInMemory = std::map<std::string, Log>;

/// The measurement that is searched, of all samples or of an excerpt, and the weighing of its rows.
struct Searched {
  std::unique_ptr<Measurement> measurement;
  RowWeighing weighing;
};

/// Logs that a group of processes works on. Each process reads its share of the long logs from end to end and
/// sends the surveys to all. The first process has a SharedLogs; the others call serve_logs().
class SharedLogs {
 public:
  using Progress = std::function<void(double fraction)>;

  /// Throws InputError for the first log, in order, that cannot be used. `in_memory_bytes`: as for LongLog,
  /// for all logs together. `in_memory`: those of `paths` that are no files; only of a process alone.
  SharedLogs(ProcessGroup& group, const std::vector<std::string>& paths,
             std::size_t in_memory_bytes = LongLog::kInMemoryBytes, const Progress& progress = {},
             const LogsInMemory& in_memory = {});

  ProcessGroup& group() const { return group_; }
  const std::vector<LongLog>& logs() const { return logs_; }
  const std::vector<std::string>& paths() const { return paths_; }

  /// Measures these intervals, on this process and, where they are an excerpt by which the whole logs will be
  /// judged, on all others too. Throws InputError for logs that are too short or sampled too slowly.
  Searched measure(const std::vector<LogInterval>& intervals, const ConditioningOptions& conditioning) const;

 private:
  ProcessGroup& group_;
  std::vector<std::string> paths_;
  std::vector<LongLog> logs_;
};

/// Called by all processes but the first: does their share of SharedLogs and WholeLogs until a Dismissal.
void serve_logs(ProcessGroup& group);

}  // namespace slipstack::workbench
