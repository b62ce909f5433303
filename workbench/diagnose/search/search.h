// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/diagnose/search/forward_selection.h"

namespace slipstack::workbench {

/// The result of the search, and the trials of its first level.
struct Found {
  Explanation best;
  /// `best` with one more effect that would be a step if clocks and sensors could not err that much.
  std::optional<Explanation> withheld;
  SelectionContext context;              ///< by which its steps were judged
  std::vector<Trial> alone;              ///< every effect on the baseline, best first
  std::vector<Explanation> first_level;  ///< the best of them, fitted in full
  /// What was chosen from outside the catalogue, beside the effects of `best`, which does not contain it.
  OutsideCauses outside;
};

/// Searches for the effects that `baseline` lacks, one after the other. A beam search, because if two effects
/// are missing, the best single effect may be neither of them. The result refers to all arguments.
Found search(Measurement& measurement, const DiagnoseOptions& options, const FittedModel& baseline);

}  // namespace slipstack::workbench
