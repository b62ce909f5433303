// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/diagnose/evidence/significance.h"
#include "workbench/diagnose/search/growth.h"

namespace slipstack::workbench {

/// Drops what other effects have made superfluous: of the last one too, since what it was added to need not
/// be what the step before chose.
void prune(const Measurement& measurement, const SelectionContext& context, Explanation& explanation);

/// Gives to an effect of fewer parameters what it explains as well in the company of the others. `alone`: the
/// trials of all effects on the baseline.
void simplify(const Measurement& measurement, const SelectionContext& context,
              const std::vector<Trial>& alone, Explanation& explanation);

}  // namespace slipstack::workbench
