// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/whole_logs.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "workbench/base/parallel.h"

namespace slipstack::workbench {
namespace {

/// A window that errs so many times as much as the worst of the excerpt is a surprise.
constexpr double kPoorlyPredicted = 5.0;
constexpr std::size_t kMostPoorlyPredicted = 3;

/// The errors of `judged` in place of those of `model`.
void take_errors(FittedModel& model, const FittedModel& judged) {
  model.train_rmse_N = judged.train_rmse_N;
  model.holdout_rmse_N = judged.holdout_rmse_N;
  model.relative_error = judged.relative_error;
  model.block_squared_error = judged.block_squared_error;
  model.block_weight = judged.block_weight;
  model.log_errors = judged.log_errors;
}

/// Squares of what one of the models that say so leaves of all.
Squares squares_of(const std::vector<UnitSums>& sums, std::size_t m) {
  Squares squares;
  for (const UnitSums& one : sums) squares.add(one.squares[m]);
  return squares;
}

}  // namespace

WholeLogs::WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt,
                     const RowWeighing& weighing, ProcessGroup& group)
    : logs_(logs), excerpt_(excerpt), sums_(logs, excerpt, weighing, group) {}

MotionExtremes WholeLogs::reached() const {
  MotionExtremes all = reached_;
  if (!excerpt_.is_excerpt()) all.take(excerpt_, 0, excerpt_.sample_count());
  return all;
}

/// The sums of all units. What they tell of the logs is kept.
std::vector<UnitSums> WholeLogs::sum(const SumTask& task, const Progress& progress) {
  std::vector<UnitSums> sums = sums_.sum(task, progress);
  windows_.clear();
  for (const UnitSums& one : sums) {
    reached_.add(one.reached);
    windows_.insert(windows_.end(), one.windows.begin(), one.windows.end());
  }
  return sums;
}

/// What one of the models that say so leaves of each log.
std::vector<LogErrors> WholeLogs::log_errors(const std::vector<UnitSums>& sums, std::size_t m) const {
  std::vector<Squares> squares(logs_.size());
  for (const UnitSums& one : sums) squares[one.log].add(one.squares[m]);
  std::vector<LogErrors> errors;
  errors.reserve(squares.size());
  for (const Squares& one : squares) errors.push_back({one.rmse_N(), 0.0, one.relative()});
  return errors;
}

/// Errors of each log by the equations of all, where each row has its weight.
void WholeLogs::take_weighted_errors(const NormalEquations& equations, const std::vector<UnitSums>& sums,
                                     FittedModel& model) const {
  struct Weighted {
    double left = 0.0;
    double unobserved = 0.0;
    double weight = 0.0;
  };
  std::vector<Weighted> of_log(logs_.size());
  for (const UnitSums& one : sums) {
    const int end = one.first_block + one.equations.front().block_count();
    for (int block = one.first_block; block < end; ++block) {
      of_log[one.log].left += equations.squared_error(model.solution.value, block);
      of_log[one.log].unobserved += model.block_squared_error[static_cast<std::size_t>(block)];
      of_log[one.log].weight += equations.weight(block);
    }
  }
  for (std::size_t log = 0; log < logs_.size(); ++log) {
    const double weight = std::max(of_log[log].weight, 1e-300);
    model.log_errors[log].rmse_N = std::sqrt(of_log[log].left / weight);
    model.log_errors[log].holdout_rmse_N = std::sqrt(of_log[log].unobserved / weight);
  }
}

/// Gains and errors of one of the models.
FittedModel WholeLogs::judged(const SumTask& task, std::size_t m, const std::vector<UnitSums>& sums,
                              double error_N) const {
  const Terms& terms = task.models[m];
  NormalEquations equations(unknown_count(terms), sums_.block_count(), kFolds);
  for (const UnitSums& one : sums) equations.add(one.equations[m], one.first_block);
  equations.sum_up();
  const NormalEquations::Constraints constraints = constraints_of(terms, error_N);
  FittedModel model;
  model.solution = equations.fit(constraints);
  const auto held_out = equations.cross_validate(constraints, model.solution.bound_states);
  model.train_rmse_N = std::sqrt(equations.squared_error(model.solution.value) / equations.weight());
  model.holdout_rmse_N = held_out.rmse;
  model.block_squared_error = held_out.block_squared_error;
  for (int block = 0; block < equations.block_count(); ++block) {
    model.block_weight.push_back(equations.weight(block));
  }
  if (m >= task.full) return model;
  model.relative_error = squares_of(sums, m).relative();
  model.log_errors = log_errors(sums, m);
  take_weighted_errors(equations, sums, model);
  return model;
}

/// Of all models; `error_N` scales what is known before the data.
std::vector<FittedModel> WholeLogs::judged(const SumTask& task, double error_N, const Progress& progress) {
  const std::vector<UnitSums> sums = sum(task, progress);
  std::vector<FittedModel> models(task.models.size());
  parallel_for(models.size(), [&](std::size_t m) { models[m] = judged(task, m, sums, error_N); });
  return models;
}

void WholeLogs::fit(const std::vector<FittedModel*>& models, double limit_N, const Progress& progress) {
  if (!excerpt_.is_excerpt()) return;
  const auto half = [&progress](double from) {
    return [&progress, from](double fraction) {
      if (progress) progress(from + 0.5 * fraction);
    };
  };
  SumTask task;
  task.limit_N = limit_N;
  for (const FittedModel* model : models) task.models.push_back(model->terms);
  task.full = task.models.size();
  const std::vector<FittedModel> found = judged(task, models.front()->train_rmse_N, half(0.0));
  task.models.clear();
  for (std::size_t m = 0; m < models.size(); ++m) {
    FittedModel& model = *models[m];
    take_errors(model, found[m]);
    model.solution = found[m].solution;
    take_gains(model.terms, model.solution.value);
    model.linearisation =
        std::make_shared<const Linearisation>(excerpt_, model.terms, model.linearisation.get());
    task.models.push_back(model.terms);
  }
  // With these gains; and where terms multiply, the force is no longer the one that was linearised.
  const std::vector<Left> left = left_by(task.models, half(0.5));
  for (std::size_t m = 0; m < models.size(); ++m) {
    models[m]->relative_error = left[m].relative_error;
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      LogErrors& errors = models[m]->log_errors[log];
      errors.rmse_N = left[m].logs[log].rmse_N;
      errors.relative_error = left[m].logs[log].relative_error;
    }
  }
}

std::vector<WholeLogs::Left> WholeLogs::left_by(const std::vector<Terms>& models, const Progress& progress) {
  const std::vector<UnitSums> sums = sum({models, models.size(), 0.0}, progress);
  std::vector<Left> left;
  left.reserve(models.size());
  for (std::size_t m = 0; m < models.size(); ++m) {
    const Squares all = squares_of(sums, m);
    left.push_back({all.rmse_N(), all.relative(), log_errors(sums, m)});
  }
  return left;
}

void WholeLogs::judge(Diagnosis& diagnosis, const Progress& progress) {
  // The baseline and the steps first, of which more is told; then the candidates.
  SumTask task;
  for (const Step& step : diagnosis.steps) task.models.push_back(step.terms);
  const std::size_t full = task.full = task.models.size();
  for (const Candidate& candidate : diagnosis.candidates) task.models.push_back(candidate.terms);
  const std::vector<FittedModel> found = judged(task, diagnosis.baseline.train_rmse_N, progress);
  // An effect that the excerpt cannot show was given the baseline's error, and keeps it.
  std::vector<bool> shown;
  for (const Candidate& candidate : diagnosis.candidates) {
    shown.push_back(candidate.block_squared_error != diagnosis.baseline.block_squared_error);
  }
  take_errors(diagnosis.baseline, found[0]);
  take_errors(diagnosis.best, found[std::min<std::size_t>(1, full - 1)]);
  take_errors(diagnosis.explained, found[full - 1]);
  for (std::size_t s = 0; s < full; ++s) diagnosis.steps[s].holdout_rmse_N = found[s].holdout_rmse_N;
  for (std::size_t c = 0; c < diagnosis.candidates.size(); ++c) {
    const FittedModel& model = shown[c] ? found[full + c] : found[0];
    diagnosis.candidates[c].holdout_rmse_N = model.holdout_rmse_N;
    diagnosis.candidates[c].block_squared_error = model.block_squared_error;
  }
}

/// What of a stretch leads in was not seen by the search either.
bool WholeLogs::was_searched(const Window& window, const std::vector<LogInterval>& excerpt) const {
  for (std::size_t i = 0; i < excerpt.size(); ++i) {
    const std::size_t known = excerpt[i].first + excerpt_.parts()[i].burn_in;
    if (excerpt[i].log == window.log && window.first() >= known &&
        window.end() <= excerpt[i].first + excerpt[i].count) {
      return true;
    }
  }
  return false;
}

std::vector<LogInterval> WholeLogs::poorly_predicted(const std::vector<LogInterval>& excerpt) const {
  double reference_error_N = 0.0;
  std::vector<Window> unknown;
  for (const Window& window : windows_) {
    if (window.weight <= 0.0) continue;
    if (was_searched(window, excerpt)) {
      reference_error_N = std::max(reference_error_N, window.rmse_N());
    } else {
      unknown.push_back(window);
    }
  }
  std::sort(unknown.begin(), unknown.end(), [](const Window& a, const Window& b) {
    return std::tuple(-a.rmse_N(), a.log, a.index) < std::tuple(-b.rmse_N(), b.log, b.index);
  });
  std::vector<LogInterval> found;
  for (const Window& window : unknown) {
    if (window.rmse_N() < kPoorlyPredicted * reference_error_N || found.size() == kMostPoorlyPredicted) break;
    const LongLog& log = logs_[window.log];
    const std::size_t first = lead_into_chunk(log, window.first());
    found.push_back({window.log, first, std::min(log.sample_count(), window.end()) - first});
  }
  return found;
}

}  // namespace slipstack::workbench
