// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// What stands for a user's own effect on the controller (firmware/effects/user_table.h).
struct TabulatedEffect {
  Term term;                   ///< of `user_table`: 33 forces, and where they lie
  bool over_velocity = false;  ///< else over position
  double from = 0.0;           ///< first point, m or m/s; before it and beyond `to` the end values
  double to = 0.0;
  double reversal_velocity_mps = 0.0;  ///< below it the sign of velocity is a slope; 0: the same both ways
  double largest_error_N = 0.0;        ///< against the expression, over all that the log shows
  double peak_N = 0.0;                 ///< the largest force of the expression there
};

/// A table, or in words why there is none.
struct Tabulated {
  std::optional<TabulatedEffect> table;
  std::string why_not;
};

/// The fitted term of an own effect as a table. Its form allows one where it is f(x), f(v), f(x) sign(v) or
/// f(v) with a step at standstill, found by evaluation where the log was; the table covers where the force
/// changes. Refused where straight lines miss more than `allowed_N` and more than 1 % of the peak. Cost: some
/// 10^5 evaluations of the expression.
Tabulated tabulate(const Measurement& measurement, const Term& own, double allowed_N);

}  // namespace slipstack::workbench
