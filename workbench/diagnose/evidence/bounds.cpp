// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/bounds.h"

#include <algorithm>

#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Whether a shape has the value at which it is held until all other effects are identified.
bool is_nominal(const ShapeSpec& spec, double value) {
  if (spec.kind == ShapeKind::filter) return value == 0.0;
  const double middle = 0.5 * (static_cast<double>(spec.lower) + static_cast<double>(spec.upper));
  return spec.kind == ShapeKind::nominal_exponent && value == middle;
}

bool is_computed(ShapeKind kind) {
  return kind == ShapeKind::position || kind == ShapeKind::travel || kind == ShapeKind::slip_distance ||
         kind == ShapeKind::duration || kind == ShapeKind::table;
}

}  // namespace

bool shape_ended_at_bound(const Term& term, std::size_t shape) {
  if (term.shape_standard_errors.empty() || term.shape_standard_error(shape) > 0.0) return false;
  const ShapeSpec& spec = term.effect->shapes[shape];
  if (is_computed(spec.kind) || is_nominal(spec, term.shapes[shape])) return false;
  if (spec.kind == ShapeKind::pitch && is_one_turn(term.shapes[shape])) return false;
  const auto has_force = [](double gain) { return gain != 0.0; };
  return term.gains.empty() || std::any_of(term.gains.begin(), term.gains.end(), has_force);
}

}  // namespace slipstack::workbench
