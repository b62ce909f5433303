// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effect_adapters/shape_parameter.h"

#include <fmt/format.h>

#include "workbench/base/axis_units.h"
#include "workbench/base/quantity.h"

namespace slipstack::workbench {

ShapeBounds bounds_of(const ShapeSpec& shape) {
  ShapeBounds bounds{static_cast<double>(shape.lower), static_cast<double>(shape.upper)};
  const bool length = shape.kind != ShapeKind::user_defined && power_of_length(shape.unit) > 0;
  if (!length) return bounds;
  bounds.upper = axis_length(bounds.upper);
  if (bounds.lower < 0.0) bounds.lower = axis_length(bounds.lower);
  return bounds;
}

namespace {

bool is_exponent(const ShapeSpec& shape) {
  return shape.kind == ShapeKind::exponent || shape.kind == ShapeKind::nominal_exponent;
}

}  // namespace

std::string shape_value(const ShapeSpec& shape, double value, int significant) {
  return is_exponent(shape) ? fmt::format("{:.{}g}", value, significant)
                            : quantity(value, shape.unit, significant);
}

std::string shape_value_with_interval(const ShapeSpec& shape, double value, double half_width) {
  if (!(half_width > 0.0)) return shape_value(shape, value);
  return is_exponent(shape) ? number_with_interval(value, half_width)
                            : quantity_with_interval(value, half_width, shape.unit);
}

}  // namespace slipstack::workbench
