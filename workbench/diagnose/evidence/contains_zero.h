// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Whether a value is within two standard errors of zero (95 %).
inline bool contains_zero(double value, double standard_error) {
  return std::abs(value) <= 2.0 * standard_error;
}

/// Whether each shape is; known after with_standard_errors().
inline bool each_shape_contains_zero(const Term& term) {
  for (std::size_t i = 0; i < term.shapes.size(); ++i) {
    if (!contains_zero(term.shapes[i], term.shape_standard_error(i))) return false;
  }
  return true;
}

/// Whether delay and filter of a lag are together. Each may be where together they are not: one can take the
/// place of the other.
inline bool lag_contains_zero(const Term& lag) {
  return contains_zero(measurement_dynamics_of({lag}).total_s(), lag.lag_standard_error_s);
}

}  // namespace slipstack::workbench
