// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/search/search.h"

namespace slipstack::workbench {

/// Every effect that the search tried alone, with its best fit; as it was tried where it lowers the error by
/// less than is shown. Cost: a fit, six on parts of the data and, of what the log supports, standard errors
/// for each that is shown.
std::vector<Candidate> list_candidates(const Measurement& measurement, const Found& found);

/// Sorts the candidates by the error that each leaves alone; those of the explanation (`added`) before the
/// others, since if two effects are missing, a third may be better alone than either; of them those first
/// that the log supports alone, since the first is the first step.
void rank_candidates(Diagnosis& diagnosis, const std::vector<std::string>& added);

/// Whether the candidate as fitted on the baseline is no finding, whatever its size (plausibility.h). Cost:
/// one fit.
bool is_implausible_alone(const Measurement& measurement, const FittedModel& baseline,
                          const Candidate& candidate);

/// Moves a candidate before all others. Where errors of the excerpt were replaced by those of whole logs,
/// what is best alone may be another effect than the first step, which is what the verdict names.
void put_first(Diagnosis& diagnosis, const std::string& effect);

/// Sets the first candidate to the model of the first step, so that both say the same: the shapes may have
/// been refined since it was ranked.
void show_by_named_model(Diagnosis& diagnosis);

}  // namespace slipstack::workbench
