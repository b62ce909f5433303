// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/diagnose.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/detectability/ties.h"
#include "workbench/diagnose/detectability/undecided.h"
#include "workbench/diagnose/evidence/evidence.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/search.h"
#include "workbench/diagnose/search/steps.h"
#include "workbench/diagnose/verdict.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {
namespace {

FittedModel fit_baseline(const Measurement& measurement, const DiagnoseOptions& options) {
  return options.start.empty() ? fit_effects(measurement, options.baseline, {})
                               : fit_gains(measurement, options.start);
}

/// What was withheld, as a step on top of `best`.
Step withheld_step(const Measurement& measurement, const SelectionContext& context, const Explanation& best,
                   Explanation withheld) {
  judge_on_unseen_data(measurement, withheld.model);
  const FittedModel known = with_standard_errors(measurement, std::move(withheld.model));
  const std::string& id = withheld.added.back();
  return {id,
          known.holdout_rmse_N,
          known.forward_rmse_N,
          known.block_squared_error,
          context.criterion.difference(known, best.model),
          evidence_of(known, id),
          known.terms};
}

}  // namespace

double discrepancy_N(const FittedModel& model, double noise_floor_N) {
  return std::sqrt(std::max(0.0, explained_N2(model.holdout_rmse_N, noise_floor_N)));
}

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::missing_effect:
      return "missing_effect";
    case Verdict::complete:
      return "complete";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "unexplained";
}

const char* name_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::none:
      return "";
    case Refusal::at_floor:
      return "at_floor";
    case Refusal::implausible:
      return "implausible";
    case Refusal::too_small:
      return "too_small";
    case Refusal::superfluous:
      return "superfluous";
  }
  return "";
}

void DiagnoseOptions::report(const std::string& stage, double fraction) const {
  if (progress) progress(stage, fraction);
}

EffectSearch::EffectSearch(Measurement& measurement, const DiagnoseOptions& options)
    : measurement_(measurement), options_(options) {
  options.report("fit the baseline", 0.0);
  diagnosis_.baseline = fit_baseline(measurement, options);

  Found found = search(measurement, options, diagnosis_.baseline);
  context_ = std::make_unique<const SelectionContext>(found.context);

  options.report("judge on unseen data", 0.0);
  judge_on_unseen_data(measurement, diagnosis_.baseline);
  judge_on_unseen_data(measurement, found.best.model);
  diagnosis_.candidates = list_candidates(measurement, found);
  rank_candidates(diagnosis_, found.best.added);
  list_steps(found.context, found.best, diagnosis_);
  if (found.withheld)
    diagnosis_.withheld = withheld_step(measurement, found.context, found.best, std::move(*found.withheld));
  diagnosis_.explained = std::move(found.best.model);
  diagnosis_.outside = std::move(found.outside);
}

EffectSearch::~EffectSearch() = default;

Diagnosis EffectSearch::conclude() {
  drop_insignificant_steps(measurement_, diagnosis_);
  std::vector<std::string> added;
  for (std::size_t i = 1; i < diagnosis_.steps.size(); ++i) added.push_back(diagnosis_.steps[i].effect);
  rank_candidates(diagnosis_, added);
  if (!added.empty()) put_first(diagnosis_, added.front());
  bound_noise_floor(measurement_, diagnosis_.explained.holdout_rmse_N);
  diagnosis_.noise_floor_N = measurement_.noise_floor_N();
  judge(measurement_, diagnosis_);
  note_refusal(measurement_, diagnosis_);
  list_what_cannot_be_shown(measurement_, diagnosis_);
  list_ties(*context_, diagnosis_);
  if (diagnosis_.steps.size() >= 2) show_by_named_model(diagnosis_);
  options_.report("done", 1.0);
  return std::move(diagnosis_);
}

Diagnosis diagnose(Measurement& measurement, const DiagnoseOptions& options) {
  return EffectSearch(measurement, options).conclude();
}

}  // namespace slipstack::workbench
