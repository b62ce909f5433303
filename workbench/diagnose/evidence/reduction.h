// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace slipstack::workbench {

/// An effect is named only if it lowers the held-out error by this share: on simulated logs that the baseline
/// describes completely no effect does (tests/bench/blind).
inline constexpr double kLeastReduction = 0.03;
/// Smaller reductions are not shown. Chosen.
inline constexpr double kLeastShownReduction = 0.005;
inline constexpr double kSignificance = 3.0;  ///< standard errors

/// The share by which a model lowers a held-out error.
struct Reduction {
  double value = 0.0;
  double standard_error = 0.0;
  bool is_significant(double significance = kSignificance) const {
    return value >= kLeastReduction && value >= significance * standard_error;
  }
};

/// 1 - rms(after)/rms(before) from the squared errors of each block, with its jackknife standard error (Efron
/// and Stein 1981).
Reduction reduction(const std::vector<double>& before, const std::vector<double>& after);

/// The reduction of an rms if some rows had no more energy than expected: they hold the share `energy` of the
/// sum of squares, and `expected` of it would be normal for them.
double reduction_beyond(double energy, double expected);

/// Whether the error is lowered significantly. An effect that is strong in a few blocks only, as drag in the
/// fast moves of a log of slow ones, has a standard error as large as its reduction. The test is therefore
/// repeated without the blocks in which the reduction is largest, up to a fifth of all blocks: it is enough
/// that the others show the effect.
bool lowered_significantly(const std::vector<double>& before, const std::vector<double>& after,
                           double significance = kSignificance);

}  // namespace slipstack::workbench
