// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/diagnose/whole_logs.h"
#include "workbench/fleet/team.h"
#include "workbench/identify/excerpt.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/log/long_log.h"

namespace slipstack::workbench {

/// Logs and what of them is searched: all, or, of many samples, an excerpt.
struct Searched {
  std::unique_ptr<Measurement> measurement;
  RowWeighing weighing;
};

/// Logs that a team of processes works on: each reads its share of the long ones from end to end, and all
/// know of all. The first process has one of these; the others serve_logs().
class TeamLogs {
 public:
  using Progress = std::function<void(double fraction)>;

  /// Throws InputError for the first log, in order, that cannot be used. `in_memory_bytes`: see LongLog, of
  /// all logs together.
  TeamLogs(Team& team, const std::vector<std::string>& paths,
           std::size_t in_memory_bytes = LongLog::kInMemoryBytes, const Progress& progress = {});

  Team& team() const { return team_; }
  const std::vector<LongLog>& logs() const { return logs_; }

  /// These stretches, conditioned, here; and on all other processes where they are an excerpt that the whole
  /// logs will judge. `refuse` may throw before the rows are weighed.
  Searched measure(const std::vector<LogStretch>& stretches, const ConditioningOptions& conditioning,
                   const std::function<void(const Measurement&)>& refuse = {}) const;

 private:
  Team& team_;
  std::vector<LongLog> logs_;
};

/// Calls `work` with what of the logs is searched, all or an excerpt (searched_stretches()), and with what
/// judges by the whole of them. Where something happens that the excerpt did not show
/// (WholeLogs::surprises()) it joins the excerpt and `work` is called again, twice at most. What was searched
/// last. `refuse`: see TeamLogs::measure().
Searched search_logs(const TeamLogs& logs, const ConditioningOptions& conditioning,
                     const std::function<void(const Measurement&)>& refuse,
                     const std::function<void(Measurement&, WholeLogs&)>& work);

/// What all processes but the first do: their share of TeamLogs and of WholeLogs, until they are dismissed.
void serve_logs(Team& team);

}  // namespace slipstack::workbench
