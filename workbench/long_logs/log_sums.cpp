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

/// Samples conditioned at once, and before them at most so many in which the hysteresis finds its state.
constexpr std::size_t kPiece = 196608;
constexpr std::size_t kLongestLead = 262144;

/// Whether `model` is `base` with one more term, and all terms simply add.
bool only_adds(const Terms& base, const Terms& model) {
  if (model.size() != base.size() + 1 || any_multiplies(model)) return false;
  for (std::size_t t = 0; t < base.size(); ++t) {
    if (model[t].effect != base[t].effect || model[t].shapes != base[t].shapes) return false;
  }
  return true;
}

/// What a model leaves at the rows that count.
Eigen::VectorXd left_N(const Measurement& piece, const Linearisation& model) {
  return model.residual_N().cwiseProduct(piece.row_usable());
}

Squares squares_of(const Measurement& piece, const Linearisation& model) {
  const Eigen::VectorXd left = left_N(piece, model);
  return {left.squaredNorm(), model.measured_N().cwiseProduct(piece.row_usable()).squaredNorm(),
          left.cwiseAbs2().dot(piece.row_weights()), piece.row_weights().sum()};
}

/// Adds what a model leaves to the windows of a unit, of which the piece begins at sample `from` of the log.
void add_windows(const Measurement& piece, std::size_t from, const Linearisation& model, UnitSums& sums) {
  const Eigen::VectorXd left = left_N(piece, model);
  for (Eigen::Index row = 0; row < left.size(); ++row) {
    const std::size_t sample = from + piece.row_samples()[static_cast<std::size_t>(row)];
    const std::size_t window = sample / Window::kSamples;
    if (sums.windows.empty() || sums.windows.back().index != window) {
      sums.windows.push_back({sums.log, window, 0.0, 0.0});
    }
    sums.windows.back().squares += piece.row_weights()(row) * left(row) * left(row);
    sums.windows.back().weight += piece.row_weights()(row);
  }
}

}  // namespace

LogSums::LogSums(const std::vector<LongLog>& logs, const Measurement& excerpt, const RowWeighing& weighing,
                 ProcessGroup& group)
    : logs_(logs), excerpt_(excerpt), weighing_(weighing), group_(group) {
  const auto all = static_cast<double>(excerpt.whole_sample_count());
  for (std::size_t log = 0; log < logs.size(); ++log) {
    const std::size_t samples = logs[log].sample_count();
    const double share = static_cast<double>(samples) / all;
    const auto count = static_cast<std::size_t>(blocks_of_share(share));
    for (std::size_t b = 0; b < count; ++b) {
      const std::size_t first = samples * b / count;
      const std::size_t end = samples * (b + 1) / count;
      const bool goes_on = b > 0 && end - units_.back().borders.front() <= kPiece;
      if (!goes_on) units_.push_back({log, block_count_, {first}});
      units_.back().borders.push_back(end);
      ++block_count_;
    }
  }
}

/// Adds the samples of the unit's log that lie between the borders.
void LogSums::sum_chunk(const std::vector<std::size_t>& borders, const SumTask& task, UnitSums& sums) const {
  const LongLog& log = logs_[sums.log];
  const std::size_t margin = excerpt_.margin();
  const std::size_t known = lead_into_chunk(log, borders.front());
  const std::size_t from = known - std::min(known, 2 * margin);
  const std::size_t to = std::min(log.sample_count(), borders.back() + margin);
  std::vector<std::size_t> local;
  local.reserve(borders.size());
  for (const std::size_t border : borders) local.push_back(border - from);
  Measurement piece({log.piece(from, to - from), sums.log, from, log.sample_count(), log.travel_m()},
                    excerpt_, local);
  sums.reached.take(piece, local.front(), local.back());
  if (piece.row_count() == 0) return;
  weighing_.apply(piece);

  const Terms& first = task.models.front();
  const Linearisation base(piece, first);
  if (task.limit_N > 0.0) {
    piece.set_row_weights(huber_weights(piece.row_weights(), base.residual_N(), task.limit_N));
  }
  const NormalEquations base_equations(piece, base.columns(), base.target());
  for (std::size_t m = 0; m < task.models.size(); ++m) {
    const Terms& terms = task.models[m];
    if (m >= task.full && only_adds(first, terms)) {
      sums.equations[m].add(equations_with(piece, base, base_equations, terms.back()), 0);
      continue;
    }
    std::optional<Linearisation> own;
    if (m > 0) own.emplace(piece, terms, &base);
    const Linearisation& model = own ? *own : base;
    sums.equations[m].add(own ? NormalEquations(piece, model.columns(), model.target()) : base_equations, 0);
    if (m < task.full) sums.squares[m].add(squares_of(piece, model));
    if (m + 1 == task.full) add_windows(piece, from, model, sums);
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
  } else {  // a block may be long
    const std::size_t end = unit.borders.back();
    for (std::size_t first = unit.borders.front(); first < end; first += kPiece) {
      sum_chunk({first, std::min(end, first + kPiece)}, task, sums);
    }
  }
  for (NormalEquations& equations : sums.equations) equations.sum_up();
  return sums;
}

/// The units that are this process's.
std::vector<UnitSums> LogSums::sum_share(const SumTask& task, const Progress& progress) const {
  std::vector<const Unit*> mine;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (static_cast<int>(u) % group_.size() == group_.rank()) mine.push_back(&units_[u]);
  }
  std::vector<UnitSums> sums(mine.size());
  std::atomic<std::size_t> done{0};
  parallel_for(mine.size(), [&](std::size_t i) {
    sums[i] = sum_unit(*mine[i], task);
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(mine.size()));
  });
  return sums;
}

std::vector<UnitSums> LogSums::sum(const SumTask& task, const Progress& progress) const {
  json request = to_json(task);
  request["do"] = "sum";
  std::vector<UnitSums> all;
  const std::vector<json> answers = ask(group_, request, [&] {
    all = sum_share(task, progress);
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

std::size_t lead_into_chunk(const LongLog& log, std::size_t sample) {
  return lead_in(log, sample, kLongestLead);
}

}  // namespace slipstack::workbench
