// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/fleet/team.h"
#include "workbench/identify/excerpt.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/log/long_log.h"

namespace slipstack::workbench {

/// Judges by the whole logs what was found on an excerpt of them. Logs are read again piece by piece; of each
/// piece only sums remain, by block: the normal equations of every model. All gains are fitted again to
/// these, and held-out errors are those of blocked cross-validation over the whole. The blocks are those of
/// the logs, each summed by one thread of one process, so the answer is the same for any number of either.
/// Memory: some pieces a thread, whatever the length of the logs. Cost: linear in samples.
class WholeLogs {
 public:
  using Progress = std::function<void(double fraction)>;

  /// `weighing` is what weigh_rows() gave for the excerpt. All references must outlive this.
  WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
            Team& team);

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
  /// How far and how fast the axis went in all logs: positions as read, the rest smoothed. Of an excerpt
  /// known after the first of these; else O(samples).
  struct Reached {
    double low_m = std::numeric_limits<double>::infinity();
    double high_m = -std::numeric_limits<double>::infinity();
    double velocity_mps = 0.0;
    double acceleration_mps2 = 0.0;
    void add(const Reached& other);
    /// Of the samples [first, end) of a measurement.
    void take(const Measurement& measurement, std::size_t first, std::size_t end);
  };
  Reached reached() const;
  /// On the others: their answer to what these ask of them.
  nlohmann::json share(const nlohmann::json& request) const;

  /// Stretches outside the excerpt, the worst first, where the last model fails by far more than anywhere in
  /// the excerpt: what happens there was not seen by the search.
  std::vector<LogStretch> surprises(const std::vector<LogStretch>& excerpt) const;

 private:
  /// Blocks of one log that follow each other: what one thread sums.
  struct Unit {
    std::size_t log = 0;
    int first_block = 0;               ///< of all logs
    std::vector<std::size_t> borders;  ///< samples at which blocks begin, and the end
    int block_count() const { return static_cast<int>(borders.size()) - 1; }
  };
  struct Sums;
  std::vector<LogErrors> log_errors(const std::vector<Sums>& sums, std::size_t model) const;
  struct Window {
    std::size_t log;
    std::size_t index;
    double squares;
    double weight;
  };
  /// What is summed.
  struct Task {
    std::vector<Terms> models;
    std::size_t full = 0;  ///< so many of them also say what they leave
    double limit_N = 0.0;  ///< see fit()
  };
  std::vector<FittedModel> judged(const Task& task, double error_N, const Progress& progress);
  std::vector<Sums> sum(const Task& task, const Progress& progress);
  std::vector<Sums> sum_share(const Task& task, const Progress& progress) const;
  static nlohmann::json to_json(const std::vector<Sums>& sums);
  static std::vector<Sums> sums_of(const nlohmann::json& list, const std::vector<Terms>& models);
  Sums sum_unit(const Unit& unit, const Task& task) const;
  void sum_piece(const Unit& unit, const std::vector<std::size_t>& borders, const Task& task,
                 Sums& sums) const;

  const std::vector<LongLog>& logs_;
  const Measurement& excerpt_;
  const RowWeighing& weighing_;
  Team& team_;
  std::vector<Unit> units_;
  int block_count_ = 0;
  std::vector<Window> windows_;
  Reached reached_;
};

}  // namespace slipstack::workbench
