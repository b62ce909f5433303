// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/long_log.h"
#include "workbench/long_logs/processes/process_group.h"
#include "workbench/long_logs/whole_logs.h"

namespace slipstack::workbench {

/// Logs and what of them is searched: all, or, of many samples, an excerpt.
struct Searched {
  std::unique_ptr<Measurement> measurement;
  RowWeighing weighing;
};

/// Logs that a team of processes works on: each reads its share of the long ones from end to end, and all
/// know of all. The first process has one of these; the others serve_logs().
class GroupLogs {
 public:
  using Progress = std::function<void(double fraction)>;

  /// Throws InputError for the first log, in order, that cannot be used. `in_memory_bytes`: see LongLog, of
  /// all logs together.
  GroupLogs(ProcessGroup& group, const std::vector<std::string>& paths,
            std::size_t in_memory_bytes = LongLog::kInMemoryBytes, const Progress& progress = {});

  ProcessGroup& group() const { return group_; }
  const std::vector<LongLog>& logs() const { return logs_; }
  const std::vector<std::string>& paths() const { return paths_; }

  /// These stretches, conditioned, here; and on all other processes where they are an excerpt that the whole
  /// logs will judge. `refuse` may throw before the rows are weighed.
  Searched measure(const std::vector<LogInterval>& intervals, const ConditioningOptions& conditioning,
                   const std::function<void(const Measurement&)>& refuse = {}) const;

 private:
  ProcessGroup& group_;
  std::vector<std::string> paths_;
  std::vector<LongLog> logs_;
};

/// What all processes but the first do: their share of GroupLogs and of WholeLogs, until they are dismissed.
void serve_logs(ProcessGroup& group);

}  // namespace slipstack::workbench
