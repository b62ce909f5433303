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
  bool earned() const { return value >= kLeastReduction && value >= kSignificance * standard_error; }
};

/// 1 - rms(after)/rms(before) from squared errors by block, with its jackknife standard error.
Reduction reduction(const std::vector<double>& before, const std::vector<double>& after);

}  // namespace slipstack::workbench
