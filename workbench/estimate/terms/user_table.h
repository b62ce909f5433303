// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The table by which the controller represents a user-defined effect
/// (firmware/effects/numerics/user_table.h).
struct TabulatedEffect {
  Term term;                   ///< of `user_table`: 33 forces and their positions
  bool over_velocity = false;  ///< else over position
  double from = 0.0;           ///< first point, m or m/s; before it and beyond `to`, the force is constant
  double to = 0.0;
  double reversal_velocity_mps = 0.0;  ///< below it the sign of velocity is a slope; 0: no factor sign(v)
  double largest_error_N = 0.0;        ///< against the expression, over the range of the log
  double peak_N = 0.0;                 ///< largest force of the expression in that range
};

/// A table, or the reason why there is none, as text.
struct Tabulated {
  std::optional<TabulatedEffect> table;
  std::string why_not;
};

/// The fitted term of a user-defined effect as a table. Its form allows one where it is f(x), f(v), f(x)
/// sign(v) or f(v) with a step at standstill, which is found by evaluation within the range of the log. The
/// table covers the range in which the force changes. Refused where its error exceeds both `allowed_N` and 1
/// % of the peak. Cost: some 10^5 evaluations of the expression.
Tabulated tabulate(const Measurement& measurement, const Term& term, double allowed_N);

}  // namespace slipstack::workbench
