// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/long_logs/long_log.h"
#include "workbench/long_logs/processes/process_group.h"
#include "workbench/long_logs/unit_sums.h"

namespace slipstack::workbench {

/// Sums over whole logs, which are read again chunk by chunk; only sums are kept of each chunk. The borders
/// of the cross-validation blocks depend on the logs alone, and each block is summed by one thread of one
/// process, so the sums are the same for any number of either. Memory: a few chunks for each thread,
/// independent of the length of the logs. Cost: linear in samples.
class LogSums {
 public:
  using Progress = std::function<void(double fraction)>;
  /// Part of the displayed progress that one pass over the logs covers.
  struct Pass {
    double from = 0.0;
    double share = 1.0;
  };

  /// Every chunk is conditioned as `excerpt` was, and its rows get weights by `weighing`, the result of
  /// weigh_rows() for the excerpt. All references must outlive this. `progress` may be empty.
  LogSums(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
          ProcessGroup& group, Progress progress = {});

  /// Number of blocks of all logs.
  int block_count() const { return block_count_; }
  /// On the first process of the group: the sums of all units in the order of their blocks; each process sums
  /// its share. Throws InputError where a log cannot be read again.
  std::vector<UnitSums> sum(const SumTask& task, Pass pass) const;
  /// On the other processes: the answer to the request that sum() sends.
  nlohmann::json share(const nlohmann::json& request) const;

 private:
  /// Consecutive blocks of one log, summed by one thread.
  struct Unit {
    std::size_t log = 0;
    int first_block = 0;               ///< of all logs
    std::vector<std::size_t> borders;  ///< first samples of the blocks, and the end of the last one
    int block_count() const { return static_cast<int>(borders.size()) - 1; }
  };
  std::vector<UnitSums> sum_share(const SumTask& task, Pass pass) const;
  UnitSums sum_unit(const Unit& unit, const SumTask& task) const;
  void sum_chunk(const std::vector<std::size_t>& borders, const SumTask& task, UnitSums& sums) const;

  const std::vector<LongLog>& logs_;
  const Measurement& excerpt_;
  const RowWeighing& weighing_;
  ProcessGroup& group_;
  Progress progress_;
  std::vector<Unit> units_;
  int block_count_ = 0;
};

/// The sample at which a chunk of a whole log must begin so that its burn-in ends before `sample`.
std::size_t chunk_start(const LongLog& log, std::size_t sample);

}  // namespace slipstack::workbench
