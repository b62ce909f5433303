// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace slipstack::workbench {

/// Whether the mean of independent observations differs from zero by no more than two of its standard errors:
/// 95 % of a normal distribution. True of fewer than two.
bool mean_is_chance(std::span<const double> observations);

/// Whether chance gives `count` signs that are all alike: their sum is within two standard deviations of
/// zero.
bool equal_signs_are_chance(std::size_t count);

/// Whether a result of this probability is within what chance gives, after it was the best of `tried`
/// independent ones (Bonferroni).
bool is_chance(double probability, double tried);

}  // namespace slipstack::workbench
