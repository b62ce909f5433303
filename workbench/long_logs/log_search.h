// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workbench/console/progress.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/long_logs/whole_logs.h"

namespace slipstack::workbench {

/// The logs of a command and how they are conditioned.
struct LogRequest {
  ProcessGroup* group = nullptr;   ///< processes that share the work
  std::vector<std::string> paths;  ///< each once
  ConditioningOptions conditioning;
  LogsInMemory in_memory = {};  ///< those of `paths` that are no files
};

/// Logs of any length. All samples of short logs are searched; of long ones an excerpt, and what is found
/// there is judged by the whole logs. The excerpt grows as long as it predicts parts of the whole logs
/// poorly:
///
///   LogSearch logs(request, progress);
///   do {
///     fit models to logs.measurement(); logs.fit_to_whole(models, limit_N);
///   } while (logs.extend());
class LogSearch {
 public:
  /// Opens and measures the logs. Throws UsageError for a log that is named twice, InputError for one that
  /// cannot be used. `progress` must outlive all use but reading the measurement and a further search.
  LogSearch(const LogRequest& request, Progress& progress);
  /// Another search of the same logs, as they were read and weighed before `opened` was extended or its
  /// measurement changed. Cost: a copy of the rows. `opened` need not outlive it.
  LogSearch(const LogSearch& opened, Progress& progress);
  ~LogSearch() = default;
  LogSearch(const LogSearch&) = delete;
  LogSearch& operator=(const LogSearch&) = delete;

  /// The measurement that is searched: of all samples, or of the excerpt.
  Measurement& measurement() { return *searched_.measurement; }
  const Measurement& measurement() const { return *searched_.measurement; }
  const std::vector<std::string>& paths() const { return logs_.paths(); }
  /// Fits the gains of `models` to the whole logs and sets their errors there (WholeLogs::fit()).
  void fit_to_whole(const std::vector<FittedModel*>& models, double limit_N) { whole_->fit(models, limit_N); }
  /// Residuals of models in the whole logs, without any fit.
  std::vector<WholeLogs::Residual> residuals_of(const std::vector<Terms>& models) {
    return whole_->residuals_of(models);
  }
  /// Extremes of the motion in the whole logs, after one of the two calls above.
  MotionExtremes reached() const { return whole_->reached(); }
  /// The effects that the model lacks: searched in the excerpt, judged by the whole logs, and searched again
  /// after the excerpt was extended. `options.start` is a model as its file has it.
  Diagnosis diagnose(DiagnoseOptions options);

  /// Extends the excerpt by the intervals of the whole logs that the last model predicts poorly, and measures
  /// it again. At most twice; false where nothing was extended, and for logs that were searched whole.
  bool extend();

  /// Hands over the measurement; no other function may be called afterwards.
  std::unique_ptr<Measurement> release() { return std::move(searched_.measurement); }

 private:
  void measure();
  void prepare_whole();

  Progress& progress_;
  ConditioningOptions conditioning_;
  SharedLogs logs_;
  std::vector<LogInterval> intervals_;
  Searched searched_;
  std::optional<WholeLogs> whole_;
  int extensions_ = 0;
};

}  // namespace slipstack::workbench
