// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/candidates.h"

#include <algorithm>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/diagnose/evidence/evidence.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {
namespace {

/// Sets the share by which the candidate lowers the baseline's error.
void set_reduction(const FittedModel& baseline, Candidate& candidate) {
  const Reduction reduced = reduction(baseline.block_squared_error, candidate.block_squared_error);
  candidate.error_reduction = reduced.value;
  candidate.error_reduction_se = reduced.standard_error;
}

/// The baseline with the effect of a trial: as the search has fitted it in full, where it has; else fitted
/// now.
FittedModel fitted_alone(const Measurement& measurement, const Found& found, const Trial& trial) {
  const std::string id = trial.term.id();
  const auto one = std::find_if(found.first_level.begin(), found.first_level.end(),
                                [&](const Explanation& full) { return full.added.front() == id; });
  return one != found.first_level.end() ? one->model
                                        : fit_gains(measurement, trial.terms, &found.context.baseline);
}

}  // namespace

std::vector<Candidate> list_candidates(const Measurement& measurement, const Found& found) {
  std::vector<Candidate> candidates(found.alone.size());
  parallel_for(candidates.size(), [&](std::size_t i) {
    const Trial& trial = found.alone[i];
    Candidate& candidate = candidates[i];
    candidate.evidence = trial.term.effect->text.residual;
    if (!is_shown(found.context.baseline.holdout_rmse_N, trial.holdout_rmse_N)) {
      candidate.term = trial.term;
      candidate.terms = trial.terms;
      candidate.holdout_rmse_N = trial.holdout_rmse_N;
      candidate.block_squared_error = trial.block_squared_error;
      return;
    }
    FittedModel model = fitted_alone(measurement, found, trial);
    judge_on_unseen_data(measurement, model);
    candidate.criterion_difference = found.context.criterion.difference(model, found.context.baseline);
    // Values, with their intervals, are told of what the log supports.
    if (is_supported(candidate.criterion_difference) &&
        is_worth_a_name(found.context.baseline.holdout_rmse_N, model.holdout_rmse_N)) {
      model = with_standard_errors(measurement, std::move(model));
      candidate.evidence = evidence_of(model, trial.term.id());
    }
    candidate.term = *find_term(model.terms, trial.term.id());
    candidate.terms = std::move(model.terms);
    candidate.holdout_rmse_N = model.holdout_rmse_N;
    candidate.block_squared_error = std::move(model.block_squared_error);
  });
  return candidates;
}

void rank_candidates(Diagnosis& diagnosis, const std::vector<std::string>& added) {
  std::vector<Candidate>& candidates = diagnosis.candidates;
  for (Candidate& candidate : candidates) set_reduction(diagnosis.baseline, candidate);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.holdout_rmse_N < b.holdout_rmse_N; });
  const auto others = std::stable_partition(candidates.begin(), candidates.end(), [&](const auto& candidate) {
    return std::find(added.begin(), added.end(), candidate.term.id()) != added.end();
  });
  std::stable_partition(candidates.begin(), others,
                        [](const auto& one) { return is_supported(one.criterion_difference); });
}

bool is_implausible_alone(const Measurement& measurement, const FittedModel& baseline,
                          const Candidate& candidate) {
  FittedModel fitted = fit_gains(measurement, candidate.terms);
  fitted.holdout_rmse_N = candidate.holdout_rmse_N;
  return is_implausible(measurement, baseline, fitted);
}

void put_first(Diagnosis& diagnosis, const std::string& effect) {
  std::stable_partition(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                        [&](const Candidate& candidate) { return candidate.term.id() == effect; });
}

void show_by_named_model(Diagnosis& diagnosis) {
  Candidate& first = diagnosis.candidates.front();
  first.term = *find_term(diagnosis.best.terms, first.term.id());
  first.terms = diagnosis.best.terms;
  first.holdout_rmse_N = diagnosis.best.holdout_rmse_N;
  first.block_squared_error = diagnosis.best.block_squared_error;
  first.criterion_difference = diagnosis.steps[1].criterion_difference;
  first.evidence = diagnosis.steps[1].evidence;
  set_reduction(diagnosis.baseline, first);
}

}  // namespace slipstack::workbench
