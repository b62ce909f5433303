// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/undecided.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
void list_what_cannot_be_shown(const Measurement& measurement, Diagnosis& diagnosis) {
  const FittedModel& explained = diagnosis.explained;
  const double force_N = measurement.weighted_rms(explained.linearisation->measured_N());
  const ResidualMaker residual_maker = baseline_residual_maker(measurement, explained);
  std::vector<Visibility> all(diagnosis.candidates.size());
  parallel_for(all.size(), [&](std::size_t i) {
    const Term& term = diagnosis.candidates[i].term;
    const std::string id = term.id();
    const std::vector<std::string>& beside = diagnosis.outside.beside;
    if (contains(explained.terms, id) || std::find(beside.begin(), beside.end(), id) != beside.end()) return;
    // An effect that lowers the error is not one that the log cannot show, whatever else explains the same.
    if (diagnosis.candidates[i].error_reduction >= kLeastShownReduction) return;
    all[i] = visibility_of(measurement, explained, residual_maker, term, kLeastReduction);
  });
  for (Visibility& one : all) {
    if (!one.effect.empty() && one.least_rms_N > kLargeShareOfForce * force_N)
      diagnosis.cannot_show.push_back(std::move(one));
  }
}

}  // namespace slipstack::workbench
