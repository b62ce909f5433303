// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/log_sums.h"

namespace slipstack::workbench {

/// Judges models that were found on an excerpt by the whole logs, using the normal equations of every model
/// over all samples (LogSums): the gains are fitted again to these, and held-out errors are those of blocked
/// cross-validation over the whole logs. The answer is the same for any number of threads and processes.
/// Memory: a few chunks for each thread, independent of the length of the logs. Cost: linear in samples. All
/// functions are called on the first process of the group; they throw InputError where a log cannot be read
/// again.
class WholeLogs {
 public:
  /// `weighing` is the result of weigh_rows() for the excerpt. All references must outlive this. `progress`
  /// may be empty.
  WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
            ProcessGroup& group, LogSums::Progress progress = {});

  /// Replaces the errors in the excerpt by those in the whole logs, for the baseline, every candidate and
  /// every step.
  void judge(Diagnosis& diagnosis);
  /// Fits the gains of models that were fitted to the excerpt to the whole logs, and sets the errors there;
  /// shapes and standard errors remain those of the excerpt. Does nothing where the excerpt is all of the
  /// logs. Where the residual of the first model exceeds `limit_N`, rows get the weights of Huber's loss
  /// (RobustFit); 0: no limit. poorly_predicted() then refers to the last model.
  void fit(const std::vector<FittedModel*>& models, double limit_N);
  /// Residuals of models without any fit: weighted rms [N] and share of the force; of all logs and of each.
  struct Residual {
    double rmse_N = 0.0;
    double relative_error = 0.0;
    std::vector<LogErrors> logs;
  };
  std::vector<Residual> residuals_of(const std::vector<Terms>& models);
  /// Extremes of the motion in all logs. With an excerpt they are known after the first call of one of the
  /// functions above; else O(samples).
  MotionExtremes reached() const;

  /// Intervals outside the excerpt that the last model predicts poorly (poorly_predicted.h).
  std::vector<LogInterval> poorly_predicted(const std::vector<LogInterval>& excerpt) const;

 private:
  std::vector<UnitSums> sum(const SumTask& task, LogSums::Pass pass);
  std::vector<Residual> residuals_of(const std::vector<Terms>& models, LogSums::Pass pass);
  /// A model after one Gauss-Newton step from the gains of a task, and the error at those gains.
  struct Judged {
    FittedModel model;
    double before_rmse_N = 0.0;
  };
  std::vector<Judged> judged(const SumTask& task, double error_N, LogSums::Pass pass);
  Judged judged(const SumTask& task, std::size_t m, const std::vector<UnitSums>& sums, double error_N) const;
  std::vector<FittedModel> converged(const SumTask& task, double error_N, LogSums::Pass pass);
  std::vector<bool> last_third(const std::vector<UnitSums>& sums) const;
  std::vector<LogErrors> log_errors(const std::vector<UnitSums>& sums, std::size_t m) const;
  void take_weighted_errors(const NormalEquations& equations, const std::vector<UnitSums>& sums,
                            FittedModel& model) const;

  const std::vector<LongLog>& logs_;
  const Measurement& excerpt_;
  LogSums sums_;
  std::vector<Window> windows_;  ///< of the last model
  MotionExtremes reached_;
};

}  // namespace slipstack::workbench
