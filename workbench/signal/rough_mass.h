// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Mass by ordinary least squares on a log that is smoothed so strongly that the encoder's steps (0: unknown)
/// do not matter: accurate enough to choose filters, no more.
/// The intervals of `cut` (ascending), and what the smoothing carries from them, are left out. O(n).
double rough_mass_kg(const std::vector<double>& position_m, const std::vector<double>& force_N,
                     double rate_Hz, double resolution_m, const std::vector<Interval>& cut);

}  // namespace slipstack::workbench
