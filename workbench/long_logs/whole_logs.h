// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/log_sums.h"

namespace slipstack::workbench {

/// Judges by the whole logs what was found on an excerpt of them, by the normal equations of every model over
/// all their samples (LogSums): all gains are fitted again to these, and held-out errors are those of blocked
/// cross-validation over the whole. The answer is the same for any number of threads and processes. Memory:
/// some pieces a thread, whatever the length of the logs. Cost: linear in samples.
class WholeLogs {
 public:
  using Progress = LogSums::Progress;

  /// `weighing` is what weigh_rows() gave for the excerpt. All references must outlive this.
  WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
            ProcessGroup& group);

  /// On the first process of the team: puts the errors of the whole logs in place of the excerpt's, for the
  /// baseline, every candidate and every step. Throws InputError where a log cannot be read again.
  void judge(Diagnosis& diagnosis, const Progress& progress);
  /// On the first: fits the gains of models that were fitted to the excerpt again, to the whole, and judges
  /// them by it; shapes and standard errors stay those of the excerpt. Nothing where the excerpt is all there
  /// is. Instants at which the first model leaves more than `limit_N` pull no more than there (RobustFit); 0:
  /// none. What the last model leaves is what surprises() looks at.
  void fit(const std::vector<FittedModel*>& models, double limit_N, const Progress& progress);
  /// What models leave as they are, nothing fitted: weighted rms [N], and the share of the force; of all, and
  /// of each log.
  struct Left {
    double rmse_N = 0.0;
    double relative_error = 0.0;
    std::vector<LogErrors> logs;
  };
  std::vector<Left> left_by(const std::vector<Terms>& models, const Progress& progress);
  /// What the axis reached in all logs. Of an excerpt known after the first of these; else O(samples).
  MotionExtremes reached() const;

  /// Stretches outside the excerpt, the worst first, where the last model fails by far more than anywhere in
  /// the excerpt: what happens there was not seen by the search.
  std::vector<LogInterval> poorly_predicted(const std::vector<LogInterval>& excerpt) const;

 private:
  std::vector<UnitSums> sum(const SumTask& task, const Progress& progress);
  std::vector<FittedModel> judged(const SumTask& task, double error_N, const Progress& progress);
  FittedModel judged(const SumTask& task, std::size_t m, const std::vector<UnitSums>& sums,
                     double error_N) const;
  std::vector<LogErrors> log_errors(const std::vector<UnitSums>& sums, std::size_t m) const;
  void take_weighted_errors(const NormalEquations& equations, const std::vector<UnitSums>& sums,
                            FittedModel& model) const;
  bool was_searched(const Window& window, const std::vector<LogInterval>& excerpt) const;

  const std::vector<LongLog>& logs_;
  const Measurement& excerpt_;
  LogSums sums_;
  std::vector<Window> windows_;  ///< of the last model
  MotionExtremes reached_;
};

}  // namespace slipstack::workbench
