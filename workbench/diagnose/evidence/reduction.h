// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace slipstack::workbench {

/// An effect is named when it lowers the held-out error by this much: on logs with nothing hidden no effect
/// does (design.md; tests/bench/blind shows it).
inline constexpr double kLeastReduction = 0.03;
inline constexpr double kSignificance = 3.0;  ///< standard errors

/// What a model lowers a held-out error by.
struct Reduction {
  double value = 0.0;
  double standard_error = 0.0;
  bool is_significant(double significance = kSignificance) const {
    return value >= kLeastReduction && value >= significance * standard_error;
  }
};

/// 1 - rms(after)/rms(before) from squared errors by block, with its jackknife standard error.
Reduction reduction(const std::vector<double>& before, const std::vector<double>& after);

/// What some rows add to an rms beyond what rows like the others would: these hold the share `energy` of all
/// squares, where `expected` would be no news.
double reduction_beyond(double energy, double expected);

/// Whether the error is lowered beyond chance. An effect that is loud in a few blocks alone, as drag is in
/// the fast moves of a log of slow ones, makes the standard error as large as itself: then the others must
/// show it, without up to a fifth of the blocks that speak loudest for it.
bool lowered_significantly(const std::vector<double>& before, const std::vector<double>& after,
                           double significance = kSignificance);

}  // namespace slipstack::workbench
