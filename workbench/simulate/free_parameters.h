// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// One degree of freedom of a model in a fit by simulation: a gain, or the common factor of gains that form a
/// map or the elements of the hysteresis, since a position alone does not determine each of these. Shapes are
/// held: where they were free too, fits to EMPS [5] predicted unseen positions worse (2026-11-22).
struct FreeParameter {
  std::size_t term = 0;
  std::size_t first = 0;  ///< of the gains of the term
  std::size_t count = 1;  ///< more than one: a factor
  double lower = 0.0;
  double upper = 0.0;
  double step = 0.0;  ///< of the difference quotient

  bool is_factor() const { return count > 1; }
};

/// The free parameters of a fitted model. Held is what the log declares, what is at its bound, and what has
/// no influence.
std::vector<FreeParameter> free_parameters(const FittedModel& fitted);

/// The value of a parameter; a factor is relative to `reference`, whose gains it multiplies.
double value_of(const FreeParameter& parameter, const Terms& terms, const Terms& reference);
/// Sets the parameter, within its bounds.
void set_value(const FreeParameter& parameter, double value, const Terms& reference, Terms& terms);

/// Keeps gains that are a part of another effect's gain (PartOfAnother) within it.
void keep_parts_within(Terms& terms);

}  // namespace slipstack::workbench
