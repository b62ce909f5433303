// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effects/shape_text.h"

#include <fmt/format.h>

#include "workbench/base/quantity.h"

namespace slipstack::workbench {

std::string shape_value(const ShapeSpec& shape, double value, int significant) {
  const bool is_exponent = shape.kind == ShapeKind::exponent || shape.kind == ShapeKind::nominal_exponent;
  return is_exponent ? fmt::format("{:.{}g}", value, significant) : quantity(value, shape.unit, significant);
}

}  // namespace slipstack::workbench
