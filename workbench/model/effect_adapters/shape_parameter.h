// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// Bounds of a shape parameter on the axis at hand. The headers of the effects give them for a linear axis;
/// on a rotary one the far bound of a length is the angle at the reference radius (axis_units.h). Near
/// bounds, which exclude what no encoder resolves, stay.
struct ShapeBounds {
  double lower;
  double upper;
};
ShapeBounds bounds_of(const ShapeSpec& shape);

/// quantity() of a shape parameter; an exponent is a plain number, not a percentage.
std::string shape_value(const ShapeSpec& shape, double value, int significant = 3);
/// The same with an interval to either side (quantity_with_interval()); as shape_value() without one.
std::string shape_value_with_interval(const ShapeSpec& shape, double value, double half_width);

}  // namespace slipstack::workbench
