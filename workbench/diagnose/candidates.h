// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/search/search.h"

namespace slipstack::workbench {

/// Held-out errors nearer than this share are not told apart.
inline constexpr double kIndistinct = 0.02;

/// Every effect that the search tried alone, as it was fitted best.
std::vector<Candidate> list_candidates(const Found& found);

/// All candidates by what they explain on their own; those of the explanation (`added`) before the others,
/// since of a pair an impostor may look best alone. Those of equal error are named as confounded.
void rank_candidates(Diagnosis& diagnosis, const std::vector<std::string>& added);

/// Gives the first candidate, the one effect that is missing, the error that the best model has: its shapes
/// have been settled since it was ranked among the others, whose shapes have not.
void show_by_named_model(Diagnosis& diagnosis);

}  // namespace slipstack::workbench
