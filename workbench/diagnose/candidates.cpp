// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/candidates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/diagnose/evidence/evidence.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// Sets the share by which the candidate lowers the baseline's error.
void set_reduction(const FittedModel& baseline, Candidate& candidate) {
  const Reduction reduced = reduction(baseline.block_squared_error, candidate.block_squared_error);
  candidate.error_reduction = reduced.value;
  candidate.error_reduction_se = reduced.standard_error;
}

}  // namespace

std::vector<Candidate> list_candidates(const Found& found) {
  std::vector<Candidate> candidates;
  candidates.reserve(found.alone.size());
  for (const Trial& trial : found.alone) {
    Candidate candidate;
    candidate.term = trial.term;
    candidate.terms = trial.terms;
    candidate.holdout_rmse_N = trial.holdout_rmse_N;
    candidate.block_squared_error = trial.block_squared_error;
    for (const Explanation& full : found.first_level) {
      if (full.added[0] != trial.term.id()) continue;
      candidate.term = *find_term(full.model.terms, full.added[0]);
      candidate.terms = full.model.terms;
      candidate.holdout_rmse_N = full.model.holdout_rmse_N;
      candidate.block_squared_error = full.model.block_squared_error;
    }
    candidate.evidence = evidence_of(candidate.term);
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

void rank_candidates(Diagnosis& diagnosis, const std::vector<std::string>& added) {
  std::vector<Candidate>& candidates = diagnosis.candidates;
  for (Candidate& candidate : candidates) set_reduction(diagnosis.baseline, candidate);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.holdout_rmse_N < b.holdout_rmse_N; });
  std::stable_partition(candidates.begin(), candidates.end(), [&](const auto& candidate) {
    return std::find(added.begin(), added.end(), candidate.term.id()) != added.end();
  });
  for (Candidate& candidate : candidates) {
    candidate.confounded_with.clear();
    for (const Candidate& other : candidates) {
      if (&other == &candidate || other.error_reduction < kLeastReduction) continue;
      const double apart = std::abs(other.holdout_rmse_N - candidate.holdout_rmse_N);
      if (apart <= kIndistinct * candidate.holdout_rmse_N) {
        candidate.confounded_with.push_back(other.term.id());
      }
    }
  }
}

void show_by_named_model(Diagnosis& diagnosis) {
  Candidate& first = diagnosis.candidates.front();
  if (diagnosis.best.holdout_rmse_N >= first.holdout_rmse_N) return;
  first.term = *find_term(diagnosis.best.terms, first.term.id());
  first.terms = diagnosis.best.terms;
  first.holdout_rmse_N = diagnosis.best.holdout_rmse_N;
  first.block_squared_error = diagnosis.best.block_squared_error;
  first.evidence = evidence_of(first.term);
  set_reduction(diagnosis.baseline, first);
}

}  // namespace slipstack::workbench
