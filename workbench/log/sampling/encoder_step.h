// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

namespace slipstack::workbench {

// The step of the grid on which recorded positions lie: the largest number of which at least 99 % of their
// changes are integer multiples, so that a few interpolated samples do not halve it. Changes below
// `storage_error_m` count as no change. Empty when the positions lie on no grid (filtered, or simulated
// without an encoder), or change fewer than ten times. Cost: one pass over the positions; the search itself
// looks at 4096 changes at most.
std::optional<double> estimate_encoder_step(const std::vector<double>& position_m, double storage_error_m);

}  // namespace slipstack::workbench
