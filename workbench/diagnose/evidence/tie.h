// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

namespace slipstack::workbench {

/// An effect of the explanation, and another that explains the log as well in its place.
struct Tie {
  std::string effect;
  std::string other;
};

/// Whether the mean of independent observations differs from zero by no more than two of its standard errors:
/// 95 % of a normal distribution. True of fewer than two.
bool mean_is_chance(std::span<const double> observations);

/// Whether two models predict unseen data equally well, as far as chance allows: the mean difference of their
/// squared held-out errors is chance (Vuong 1989 for models of which neither contains the other; Diebold and
/// Mariano 1995 for squared errors of prediction). Blocks, longer than any memory of filter and motion, are
/// the independent observations. Squared errors of the same blocks.
bool within_chance(const std::vector<double>& one, const std::vector<double>& other);

}  // namespace slipstack::workbench
