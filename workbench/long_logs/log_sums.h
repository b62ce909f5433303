// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/long_logs/long_log.h"
#include "workbench/long_logs/processes/process_group.h"
#include "workbench/long_logs/unit_sums.h"

namespace slipstack::workbench {

/// Sums over whole logs, which are read again piece by piece: of each piece only sums remain. The blocks are
/// those of the logs, each summed by one thread of one process, so the sums are the same for any number of
/// either. Memory: some pieces a thread, whatever the length of the logs. Cost: linear in samples.
class LogSums {
 public:
  using Progress = std::function<void(double fraction)>;

  /// Every piece is conditioned as `excerpt` was, and its rows weighed by what weigh_rows() gave for it. All
  /// references must outlive this.
  LogSums(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
          ProcessGroup& group);

  /// Blocks of all logs.
  int block_count() const { return block_count_; }
  /// On the first process of the team: every unit, by block; each process sums its share. Throws InputError
  /// where a log cannot be read again.
  std::vector<UnitSums> sum(const SumTask& task, const Progress& progress) const;
  /// On the others: their answer to what sum() asks of them.
  nlohmann::json share(const nlohmann::json& request) const;

 private:
  /// Blocks of one log that follow each other: what one thread sums.
  struct Unit {
    std::size_t log = 0;
    int first_block = 0;               ///< of all logs
    std::vector<std::size_t> borders;  ///< samples at which blocks begin, and the end
    int block_count() const { return static_cast<int>(borders.size()) - 1; }
  };
  std::vector<UnitSums> sum_share(const SumTask& task, const Progress& progress) const;
  UnitSums sum_unit(const Unit& unit, const SumTask& task) const;
  void sum_chunk(const std::vector<std::size_t>& borders, const SumTask& task, UnitSums& sums) const;

  const std::vector<LongLog>& logs_;
  const Measurement& excerpt_;
  const RowWeighing& weighing_;
  ProcessGroup& group_;
  std::vector<Unit> units_;
  int block_count_ = 0;
};

/// Where a piece of a whole log must begin so that the state is known at `sample`.
std::size_t lead_into_chunk(const LongLog& log, std::size_t sample);

}  // namespace slipstack::workbench
