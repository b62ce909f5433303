// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/significance.h"
#include "workbench/diagnose/search/growth.h"

namespace slipstack::workbench {

/// What the search came to, and what its first level said.
struct Found {
  Explanation best;
  SelectionContext context;              ///< what its steps were held against
  std::vector<Trial> alone;              ///< every effect on the baseline, best first
  std::vector<Explanation> first_level;  ///< the best of them, fitted in full
};

/// Grows explanations of what `baseline` leaves, effect by effect: a beam search, because of a pair the best
/// single effect may be neither. Refers to `baseline` and `floor` in what it returns.
Found search(const Measurement& measurement, const DiagnoseOptions& options, const FittedModel& baseline,
             const NoiseFloor& floor);

}  // namespace slipstack::workbench
