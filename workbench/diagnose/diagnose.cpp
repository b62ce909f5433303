// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/diagnose.h"

#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/judgement.h"
#include "workbench/diagnose/mass_and_mode.h"
#include "workbench/diagnose/search.h"
#include "workbench/diagnose/simplify.h"
#include "workbench/diagnose/steps.h"
#include "workbench/diagnose/undecided.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/identify/standard_errors.h"

namespace slipstack::workbench {
namespace {

FittedModel fit_baseline(const Measurement& measurement, const DiagnoseOptions& options) {
  return options.start.empty() ? fit_effects(measurement, options.baseline, {})
                               : fit_gains(measurement, options.start);
}

/// What the search found, without what is superfluous, as simple as it can be, its shapes settled.
void settle(const Measurement& measurement, Found& found) {
  prune(measurement, found.yardstick, found.best);
  if (found.best.added.empty()) return;
  simplify(measurement, found.yardstick, found.alone, found.best);
  name_mass_beside_mode(measurement, found.yardstick, found.best);
  found.best.model = settle_customary_shapes(measurement, std::move(found.best.model));
  found.best.model = settle_shapes(measurement, std::move(found.best.model));
  // With shapes settled, the first may do what another was added for.
  if (found.best.added.size() > 1) prune(measurement, found.yardstick, found.best);
}

/// Puts the errors that the whole logs show in place of the excerpt's; what they do not bear out goes.
void judge_on_whole(const Measurement& measurement, const DiagnoseOptions& options, Diagnosis& diagnosis) {
  options.report("judge by the whole logs", 0.0);
  options.judge_on_whole(diagnosis);
  drop_unearned_steps(measurement, diagnosis);
  std::vector<std::string> added;
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) added.push_back(diagnosis.steps[i].added);
  rank_candidates(diagnosis, added);
}

}  // namespace

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

void DiagnoseOptions::report(const std::string& stage, double fraction) const {
  if (progress) progress(stage, fraction);
}

Diagnosis diagnose(const Measurement& measurement, const DiagnoseOptions& options) {
  const NoiseFloor floor(measurement);
  Diagnosis diagnosis;
  options.report("fit the baseline", 0.0);
  diagnosis.baseline = fit_baseline(measurement, options);

  Found found = search(measurement, options, diagnosis.baseline, floor);
  settle(measurement, found);

  diagnosis.candidates = list_candidates(found);
  rank_candidates(diagnosis, found.best.added);
  list_steps(measurement, found.best, diagnosis);
  diagnosis.explained = std::move(found.best.model);
  if (options.judge_on_whole) judge_on_whole(measurement, options, diagnosis);
  diagnosis.noise_floor_N = floor.of(diagnosis.explained.terms);

  judge(measurement, diagnosis);
  list_what_cannot_be_shown(measurement, diagnosis);
  list_what_cannot_be_separated(measurement, diagnosis);
  if (diagnosis.steps.size() == 2) show_as_handed_out(diagnosis);
  options.report("done", 1.0);
  return diagnosis;
}

}  // namespace slipstack::workbench
