// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace slipstack::workbench {

/// An effect is named only if it lowers the held-out error by this share: on simulated logs that the baseline
/// describes completely no effect does (tests/bench/blind).
inline constexpr double kLeastReduction = 0.03;
/// Smaller reductions are not shown. Chosen.
inline constexpr double kLeastShownReduction = 0.005;

/// The share by which a model lowers a held-out error.
struct Reduction {
  double value = 0.0;
  double standard_error = 0.0;
};

/// 1 - rms(after)/rms(before) from the squared errors of each block, with its jackknife standard error (Efron
/// and Stein 1981).
Reduction reduction(const std::vector<double>& before, const std::vector<double>& after);

/// The reduction of an rms if some rows had no more energy than expected: they hold the share `energy` of the
/// sum of squares, and `expected` of it would be normal for them.
double reduction_beyond(double energy, double expected);

}  // namespace slipstack::workbench
