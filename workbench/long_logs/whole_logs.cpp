// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/whole_logs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/long_logs/poorly_predicted.h"

namespace slipstack::workbench {
namespace {

/// Replaces the errors of `model` by those of `judged`.
void take_errors(FittedModel& model, const FittedModel& judged) {
  model.train_rmse_N = judged.train_rmse_N;
  model.holdout_rmse_N = judged.holdout_rmse_N;
  model.forward_rmse_N = judged.forward_rmse_N;
  model.forward_within_travel_N = judged.forward_rmse_N;  // the sums do not tell where the axis was
  model.last_third_holdout_rmse_N = judged.last_third_holdout_rmse_N;
  model.relative_error = judged.relative_error;
  model.block_squared_error = judged.block_squared_error;
  model.block_weight = judged.block_weight;
  model.log_errors = judged.log_errors;
}

/// Passes over the logs, at most, in which the gains of effects that multiply converge. From the solution of
/// the excerpt they need two or three.
constexpr int kMostPasses = 6;
/// Relative decrease of the error that ends them.
constexpr double kConverged = 1e-4;

/// Replaces errors in which outliers count less, as in the fit, by those in which every row counts by its
/// noise. What outliers add to the squares in sample they add to the squares held out.
void take_plain_errors(FittedModel& model, const WholeLogs::Residual& residual) {
  const double added_N2 = squared(residual.rmse_N) - squared(model.train_rmse_N);
  const double held_out_N2 = squared(model.holdout_rmse_N);
  const double scale = std::max(0.0, held_out_N2 + added_N2) / std::max(held_out_N2, 1e-300);
  for (double& block : model.block_squared_error) block *= scale;
  for (LogErrors& log : model.log_errors) log.holdout_rmse_N *= std::sqrt(scale);
  model.holdout_rmse_N *= std::sqrt(scale);
  model.last_third_holdout_rmse_N *= std::sqrt(scale);
  model.forward_rmse_N = std::sqrt(std::max(0.0, squared(model.forward_rmse_N) + added_N2));
  model.forward_within_travel_N = model.forward_rmse_N;
  model.train_rmse_N = residual.rmse_N;
  model.relative_error = residual.relative_error;
}

/// Squares of the residual of model `m` over all logs; m < SumTask::full.
Squares squares_of(const std::vector<UnitSums>& sums, std::size_t m) {
  Squares squares;
  for (const UnitSums& one : sums) squares.add(one.squares[m]);
  return squares;
}

}  // namespace

WholeLogs::WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt,
                     const RowWeighing& weighing, ProcessGroup& group, LogSums::Progress progress)
    : logs_(logs), excerpt_(excerpt), sums_(logs, excerpt, weighing, group, std::move(progress)) {}

MotionExtremes WholeLogs::reached() const {
  MotionExtremes all = reached_;
  if (!excerpt_.is_excerpt()) all.take(excerpt_, 0, excerpt_.sample_count());
  return all;
}

/// The sums of all units; keeps the windows and the extremes of the motion.
std::vector<UnitSums> WholeLogs::sum(const SumTask& task, LogSums::Pass pass) {
  std::vector<UnitSums> sums = sums_.sum(task, pass);
  windows_.clear();
  for (const UnitSums& one : sums) {
    reached_.add(one.reached);
    windows_.insert(windows_.end(), one.windows.begin(), one.windows.end());
  }
  return sums;
}

/// Errors of model `m` in each log; m < SumTask::full.
std::vector<LogErrors> WholeLogs::log_errors(const std::vector<UnitSums>& sums, std::size_t m) const {
  std::vector<Squares> squares(logs_.size());
  for (const UnitSums& one : sums) squares[one.log].add(one.squares[m]);
  std::vector<LogErrors> errors;
  errors.reserve(squares.size());
  for (const Squares& one : squares) errors.push_back({one.rmse_N(), 0.0, one.relative()});
  return errors;
}

/// Sets the weighted errors of each log, from the normal equations of all.
void WholeLogs::take_weighted_errors(const NormalEquations& equations, const std::vector<UnitSums>& sums,
                                     FittedModel& model) const {
  struct Weighted {
    double squared_error = 0.0;
    double held_out = 0.0;
    double weight = 0.0;
  };
  std::vector<Weighted> of_log(logs_.size());
  for (const UnitSums& one : sums) {
    const int end = one.first_block + one.equations.front().block_count();
    for (int block = one.first_block; block < end; ++block) {
      of_log[one.log].squared_error += equations.squared_error(model.solution.value, block);
      of_log[one.log].held_out += model.block_squared_error[static_cast<std::size_t>(block)];
      of_log[one.log].weight += equations.weight(block);
    }
  }
  for (std::size_t log = 0; log < logs_.size(); ++log) {
    const double weight = std::max(of_log[log].weight, 1e-300);
    model.log_errors[log].rmse_N = std::sqrt(of_log[log].squared_error / weight);
    model.log_errors[log].holdout_rmse_N = std::sqrt(of_log[log].held_out / weight);
  }
}

/// The blocks of the last third of each log.
std::vector<bool> WholeLogs::last_third(const std::vector<UnitSums>& sums) const {
  // The units are in order, and those of a log follow each other.
  std::vector<int> first(logs_.size(), -1);
  std::vector<int> count(logs_.size(), 0);
  for (const UnitSums& one : sums) {
    if (first[one.log] < 0) first[one.log] = one.first_block;
    count[one.log] += one.equations.front().block_count();
  }
  std::vector<bool> last(static_cast<std::size_t>(sums_.block_count()), false);
  for (std::size_t log = 0; log < logs_.size(); ++log) mark_last_third(first[log], count[log], last);
  return last;
}

/// Gains and errors of model `m`.
WholeLogs::Judged WholeLogs::judged(const SumTask& task, std::size_t m, const std::vector<UnitSums>& sums,
                                    double error_N) const {
  const Terms& terms = task.models[m];
  NormalEquations equations(unknown_count(terms), sums_.block_count(), kFolds);
  for (const UnitSums& one : sums) equations.add(one.equations[m], one.first_block);
  equations.sum_up();
  const NormalEquations::Constraints constraints = constraints_of(terms, error_N);
  Judged result;
  result.before_rmse_N = std::sqrt(equations.squared_error(gains_of(terms)) / equations.weight());
  FittedModel& model = result.model;
  model.solution = equations.fit(constraints);
  const auto held_out = equations.cross_validate(constraints, model.solution.bound_states);
  model.train_rmse_N = std::sqrt(equations.squared_error(model.solution.value) / equations.weight());
  model.holdout_rmse_N = held_out.rmse;
  model.block_squared_error = held_out.block_squared_error;
  const std::vector<bool> last = last_third(sums);
  model.forward_rmse_N = equations.error_without(last, constraints, model.solution.bound_states);
  for (int block = 0; block < equations.block_count(); ++block) {
    model.block_weight.push_back(equations.weight(block));
  }
  model.last_third_holdout_rmse_N = rmse_of_blocks(model.block_squared_error, model.block_weight, last);
  if (m >= task.full) return result;
  model.relative_error = squares_of(sums, m).relative();
  model.log_errors = log_errors(sums, m);
  take_weighted_errors(equations, sums, model);
  return result;
}

/// Gains and errors of all models; `error_N` scales the prior knowledge (constraints_of()).
std::vector<WholeLogs::Judged> WholeLogs::judged(const SumTask& task, double error_N, LogSums::Pass pass) {
  const std::vector<UnitSums> sums = sum(task, pass);
  std::vector<Judged> models(task.models.size());
  parallel_for(models.size(), [&](std::size_t m) { models[m] = judged(task, m, sums, error_N); });
  return models;
}

/// The same, with further passes for models whose effects multiply: Gauss-Newton steps, halved where the
/// error of the model itself does not fall. For one that is not full, and lowers the error of the first by
/// less than is shown, the first pass is enough.
std::vector<FittedModel> WholeLogs::converged(const SumTask& task, double error_N, LogSums::Pass pass) {
  std::vector<Judged> found = judged(task, error_N, pass);
  const std::vector<Window> windows = windows_;
  std::vector<Terms> at = task.models;
  std::vector<std::size_t> pending;
  const auto settled = [&](std::size_t m) {
    return found[m].model.train_rmse_N >= (1.0 - kConverged) * found[m].before_rmse_N;
  };
  const double baseline_N = found.front().model.holdout_rmse_N;
  for (std::size_t m = 0; m < at.size(); ++m) {
    const bool told = m < task.full || is_shown(baseline_N, found[m].model.holdout_rmse_N);
    if (told && any_multiplies(at[m]) && !settled(m)) pending.push_back(m);
  }
  for (int step = 0; step < kMostPasses && !pending.empty(); ++step) {
    SumTask next;
    next.limit_N = task.limit_N;
    for (const std::size_t m : pending) {
      next.models.push_back(at[m]);
      take_gains(next.models.back(), found[m].model.solution.value);
      if (m < task.full) ++next.full;
    }
    const std::vector<Judged> there = judged(next, error_N, pass);
    std::vector<std::size_t> still;
    for (std::size_t i = 0; i < pending.size(); ++i) {
      const std::size_t m = pending[i];
      if (there[i].before_rmse_N > found[m].before_rmse_N) {
        Eigen::VectorXd& wanted = found[m].model.solution.value;
        wanted = 0.5 * (wanted + gains_of(at[m]));
      } else {
        at[m] = next.models[i];
        found[m] = there[i];
        if (settled(m)) continue;
      }
      still.push_back(m);
    }
    pending = std::move(still);
  }
  windows_ = windows;
  std::vector<FittedModel> models;
  models.reserve(found.size());
  for (Judged& one : found) models.push_back(std::move(one.model));
  return models;
}

void WholeLogs::fit(const std::vector<FittedModel*>& models, double limit_N) {
  if (!excerpt_.is_excerpt()) return;
  SumTask task;
  task.limit_N = limit_N;
  for (const FittedModel* model : models) task.models.push_back(model->terms);
  task.full = task.models.size();
  const std::vector<FittedModel> found = converged(task, models.front()->train_rmse_N, {0.0, 0.5});
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
  // The residuals of the models as they are now.
  const std::vector<Residual> residuals = residuals_of(task.models, {0.5, 0.5});
  for (std::size_t m = 0; m < models.size(); ++m) {
    take_plain_errors(*models[m], residuals[m]);
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      LogErrors& errors = models[m]->log_errors[log];
      errors.rmse_N = residuals[m].logs[log].rmse_N;
      errors.relative_error = residuals[m].logs[log].relative_error;
    }
  }
}

std::vector<WholeLogs::Residual> WholeLogs::residuals_of(const std::vector<Terms>& models) {
  return residuals_of(models, {});
}

std::vector<WholeLogs::Residual> WholeLogs::residuals_of(const std::vector<Terms>& models,
                                                         LogSums::Pass pass) {
  const std::vector<UnitSums> sums = sum({models, models.size(), 0.0}, pass);
  std::vector<Residual> residuals;
  residuals.reserve(models.size());
  for (std::size_t m = 0; m < models.size(); ++m) {
    const Squares all = squares_of(sums, m);
    residuals.push_back({all.rmse_N(), all.relative(), log_errors(sums, m)});
  }
  return residuals;
}

void WholeLogs::judge(Diagnosis& diagnosis) {
  // First the baseline and the steps, whose errors in each log are reported, then the candidates.
  SumTask task;
  for (const Step& step : diagnosis.steps) task.models.push_back(step.terms);
  const std::size_t full = task.full = task.models.size();
  for (const Candidate& candidate : diagnosis.candidates) task.models.push_back(candidate.terms);
  const std::vector<FittedModel> found = converged(task, diagnosis.baseline.train_rmse_N, {});
  // The search gave the baseline's error to effects that the excerpt cannot show; they keep it.
  std::vector<bool> shown;
  for (const Candidate& candidate : diagnosis.candidates) {
    shown.push_back(candidate.block_squared_error != diagnosis.baseline.block_squared_error);
  }
  take_errors(diagnosis.baseline, found[0]);
  take_errors(diagnosis.best, found[std::min<std::size_t>(1, full - 1)]);
  take_errors(diagnosis.explained, found[full - 1]);
  for (std::size_t s = 0; s < full; ++s) {
    diagnosis.steps[s].holdout_rmse_N = found[s].holdout_rmse_N;
    diagnosis.steps[s].forward_rmse_N = found[s].forward_rmse_N;
    diagnosis.steps[s].block_squared_error = found[s].block_squared_error;
  }
  for (std::size_t c = 0; c < diagnosis.candidates.size(); ++c) {
    const FittedModel& model = shown[c] ? found[full + c] : found[0];
    diagnosis.candidates[c].holdout_rmse_N = model.holdout_rmse_N;
    diagnosis.candidates[c].block_squared_error = model.block_squared_error;
  }
}

std::vector<LogInterval> WholeLogs::poorly_predicted(const std::vector<LogInterval>& excerpt) const {
  return workbench::poorly_predicted(logs_, windows_, excerpt, excerpt_);
}

}  // namespace slipstack::workbench
