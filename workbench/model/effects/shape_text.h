// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// quantity() of a shape parameter; an exponent is a plain number, not a percentage.
std::string shape_value(const ShapeSpec& shape, double value, int significant = 3);

}  // namespace slipstack::workbench
