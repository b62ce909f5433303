// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// A value with its unit as people write it: 0.024 "m" -> "24.0 mm", 3.1e-4 "s" -> "310 us", 0.42 "1" -> "42
/// %". Three significant digits, unless told otherwise. Units without a customary prefix are printed as they
/// are.
std::string quantity(double value, std::string_view unit, int significant = 3);

/// The value of a shape; an exponent is a number, not a share of one.
std::string shape_value(const ShapeSpec& shape, double value, int significant = 3);

}  // namespace slipstack::workbench
