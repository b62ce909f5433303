// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace slipstack::workbench {

/// Whether the mean of independent observations differs from zero by no more than two of its standard errors:
/// 95 % of a normal distribution. True of fewer than two.
bool mean_is_chance(std::span<const double> observations);

}  // namespace slipstack::workbench
