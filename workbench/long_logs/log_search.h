// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workbench/console/progress.h"
#include "workbench/long_logs/group_logs.h"
#include "workbench/long_logs/whole_logs.h"

namespace slipstack::workbench {

/// The logs of a command and how they are conditioned.
struct LogRequest {
  ProcessGroup* group = nullptr;   ///< processes that share the work
  std::vector<std::string> paths;  ///< each once
  ConditioningOptions conditioning;
};

/// Logs of any length, and what of them is searched: all samples of short ones, of long ones an excerpt that
/// the whole logs then judge. The excerpt grows while the whole logs show something that it does not:
///
///   LogSearch logs(request, progress);
///   do {
///     fit to logs.measurement(); judge by logs.whole();
///   } while (logs.extend());
class LogSearch {
 public:
  /// Opens and measures the logs. Throws UsageError for a log that is named twice, InputError for one that
  /// cannot be used. `progress` must outlive this.
  LogSearch(const LogRequest& request, Progress& progress);

  /// What is searched.
  Measurement& measurement() { return *searched_.measurement; }
  /// The judge by all samples.
  WholeLogs& whole() { return *whole_; }
  /// Fits the gains of `models` again, to the whole logs, and judges them by these (WholeLogs::fit()).
  void fit_to_whole(const std::vector<FittedModel*>& models, double limit_N);
  /// What models leave of the whole logs as they are (WholeLogs::left_by()).
  std::vector<WholeLogs::Left> left_by(const std::vector<Terms>& models);
  /// The effects that the model lacks: found in the excerpt, judged by the whole, searched again where the
  /// excerpt grows. `options.start` is a model as its file has it.
  Diagnosis diagnose(DiagnoseOptions options);

  /// Whether the whole logs show something that the excerpt does not: it then has joined the excerpt, which
  /// is measured anew. Twice at most; false for logs that were searched whole.
  bool extend();

  /// The measurement, for one who keeps it; nothing else may be called after.
  std::unique_ptr<Measurement> release() { return std::move(searched_.measurement); }

 private:
  void measure();

  Progress& progress_;
  ConditioningOptions conditioning_;
  GroupLogs logs_;
  std::vector<LogInterval> intervals_;
  Searched searched_;
  std::optional<WholeLogs> whole_;
  int extensions_ = 0;
};

}  // namespace slipstack::workbench
