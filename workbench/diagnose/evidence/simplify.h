// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/diagnose/evidence/significance.h"
#include "workbench/diagnose/search/growth.h"

namespace slipstack::workbench {

/// Drops effects that are not significant beside the others. The effect added last is tested too, because the
/// effects that it was added to may have changed since.
void prune(const Measurement& measurement, const SelectionContext& context, Explanation& explanation);

/// Replaces an effect by one of fewer parameters that, beside the other effects, explains as much. `alone`:
/// the trials of all effects on the baseline.
void simplify(const Measurement& measurement, const SelectionContext& context,
              const std::vector<Trial>& alone, Explanation& explanation);

}  // namespace slipstack::workbench
