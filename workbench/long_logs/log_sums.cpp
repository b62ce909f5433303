// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/log_sums.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/nonlinear/trial.h"
#include "workbench/long_logs/excerpt.h"
#include "workbench/long_logs/processes/requests.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Samples of a chunk, and at most so many more before it for the burn-in of the hysteresis. Chosen: a chunk
/// with its columns takes some 25 MB (tests/unit/long_logs/memory_test.cpp).
constexpr std::size_t kChunk = 196608;
constexpr std::size_t kLongestBurnIn = 262144;

/// Whether `model` is `base` with one more term, and no term multiplies others.
bool only_adds(const Terms& base, const Terms& model) {
  if (model.size() != base.size() + 1 || any_multiplies(model)) return false;
  for (std::size_t t = 0; t < base.size(); ++t) {
    if (model[t].effect != base[t].effect || model[t].shapes != base[t].shapes) return false;
  }
  return true;
}

/// The residual of a model, zero at rows that are not used.
Eigen::VectorXd usable_residual_N(const Measurement& chunk, const Linearisation& model) {
  return model.residual_N().cwiseProduct(chunk.row_usable());
}

Squares squares_of(const Measurement& chunk, const Linearisation& model) {
  const Eigen::VectorXd residual = usable_residual_N(chunk, model);
  return {residual.squaredNorm(), model.measured_N().cwiseProduct(chunk.row_usable()).squaredNorm(),
          residual.cwiseAbs2().dot(chunk.row_weights()), chunk.row_weights().sum()};
}

/// Adds the residual of a model to the windows of a unit; the chunk begins at sample `from` of the log.
void add_windows(const Measurement& chunk, std::size_t from, const Linearisation& model, UnitSums& sums) {
  const Eigen::VectorXd residual = usable_residual_N(chunk, model);
  for (Eigen::Index row = 0; row < residual.size(); ++row) {
    const std::size_t sample = from + chunk.row_samples()[static_cast<std::size_t>(row)];
    const std::size_t window = sample / Window::kSamples;
    if (sums.windows.empty() || sums.windows.back().index != window) {
      sums.windows.push_back({sums.log, window, 0.0, 0.0});
    }
    sums.windows.back().squares += chunk.row_weights()(row) * residual(row) * residual(row);
    sums.windows.back().weight += chunk.row_weights()(row);
  }
}

}  // namespace

LogSums::LogSums(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
                 ProcessGroup& group, Progress progress)
    : logs_(logs), excerpt_(excerpt), weighing_(weighing), group_(group), progress_(std::move(progress)) {
  const auto all = static_cast<double>(excerpt.whole_sample_count());
  for (std::size_t log = 0; log < logs.size(); ++log) {
    const std::size_t samples = logs[log].sample_count();
    const double share = static_cast<double>(samples) / all;
    const auto count = static_cast<std::size_t>(blocks_of_share(share));
    for (std::size_t b = 0; b < count; ++b) {
      const std::size_t first = samples * b / count;
      const std::size_t end = samples * (b + 1) / count;
      const bool same_unit = b > 0 && end - units_.back().borders.front() <= kChunk;
      if (!same_unit) units_.push_back({log, block_count_, {first}});
      units_.back().borders.push_back(end);
      ++block_count_;
    }
  }
}

/// Adds the samples of the unit's log from the first to the last of the borders. The chunk is read with a
/// burn-in before them and with margins for the filter on both sides.
void LogSums::sum_chunk(const std::vector<std::size_t>& borders, const SumTask& task, UnitSums& sums) const {
  const LongLog& log = logs_[sums.log];
  const std::size_t margin = excerpt_.margin();
  const std::size_t start = chunk_start(log, borders.front());
  const std::size_t from = start - std::min(start, 2 * margin);
  const std::size_t to = std::min(log.sample_count(), borders.back() + margin);
  std::vector<std::size_t> local;
  local.reserve(borders.size());
  for (const std::size_t border : borders) local.push_back(border - from);
  Measurement chunk({log.chunk(from, to - from), sums.log, from, log.sample_count(), log.travel_m()},
                    excerpt_, local);
  sums.reached.take(chunk, local.front(), local.back());
  if (chunk.row_count() == 0) return;
  weighing_.apply(chunk);

  const Terms& first = task.models.front();
  const Linearisation base(chunk, first);
  if (task.limit_N > 0.0) {
    chunk.set_fit_weights(huber_weights(chunk.row_weights(), base.residual_N(), task.limit_N));
  }
  const NormalEquations base_equations(chunk, base.columns(), base.target());
  for (std::size_t m = 0; m < task.models.size(); ++m) {
    const Terms& terms = task.models[m];
    if (m >= task.full && only_adds(first, terms)) {
      sums.equations[m].add(equations_with(chunk, base, base_equations, terms.back()), 0);
      continue;
    }
    std::optional<Linearisation> own;
    if (m > 0) own.emplace(chunk, terms, &base);
    const Linearisation& model = own ? *own : base;
    sums.equations[m].add(own ? NormalEquations(chunk, model.columns(), model.target()) : base_equations, 0);
    if (m < task.full) sums.squares[m].add(squares_of(chunk, model));
    if (m + 1 == task.full) add_windows(chunk, from, model, sums);
  }
}

UnitSums LogSums::sum_unit(const Unit& unit, const SumTask& task) const {
  UnitSums sums;
  sums.log = unit.log;
  sums.first_block = unit.first_block;
  for (const Terms& model : task.models) {
    sums.equations.emplace_back(unknown_count(model), unit.block_count(), kFolds);
  }
  sums.squares.resize(task.full);
  if (unit.block_count() > 1) {
    sum_chunk(unit.borders, task, sums);
  } else {  // a single block may be longer than a chunk
    const std::size_t end = unit.borders.back();
    for (std::size_t first = unit.borders.front(); first < end; first += kChunk) {
      sum_chunk({first, std::min(end, first + kChunk)}, task, sums);
    }
  }
  for (NormalEquations& equations : sums.equations) equations.sum_up();
  return sums;
}

/// The sums of the units that are assigned to this process.
std::vector<UnitSums> LogSums::sum_share(const SumTask& task, Pass pass) const {
  std::vector<const Unit*> mine;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (static_cast<int>(u) % group_.size() == group_.rank()) mine.push_back(&units_[u]);
  }
  std::vector<UnitSums> sums(mine.size());
  std::atomic<std::size_t> done{0};
  parallel_for(mine.size(), [&](std::size_t i) {
    sums[i] = sum_unit(*mine[i], task);
    const double fraction = static_cast<double>(++done) / static_cast<double>(mine.size());
    if (progress_) progress_(pass.from + pass.share * fraction);
  });
  return sums;
}

std::vector<UnitSums> LogSums::sum(const SumTask& task, Pass pass) const {
  json request = to_json(task);
  request["do"] = "sum";
  std::vector<UnitSums> all;
  const std::vector<json> answers = ask(group_, request, [&] {
    all = sum_share(task, pass);
    return nullptr;
  });
  for (std::size_t rank = 1; rank < answers.size(); ++rank) {
    for (UnitSums& one : sums_of(answers[rank], task.models)) all.push_back(std::move(one));
  }
  std::sort(all.begin(), all.end(),
            [](const UnitSums& a, const UnitSums& b) { return a.first_block < b.first_block; });
  return all;
}

json LogSums::share(const json& request) const {
  return to_json(sum_share(task_of(request), {}));
}

std::size_t chunk_start(const LongLog& log, std::size_t sample) {
  return burn_in_start(log, sample, kLongestBurnIn);
}

}  // namespace slipstack::workbench
