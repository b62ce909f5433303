// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace slipstack::workbench {

/// The deflection of a stop operator, -1 to 1, after it moved by `way_m`; `slip_m`: its slip distance.
inline double moved(double deflection, double way_m, double slip_m) {
  return std::clamp(deflection + way_m / slip_m, -1.0, 1.0);
}

}  // namespace slipstack::workbench
