// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack::workbench {

inline double squared(double x) {
  return x * x;
}

}  // namespace slipstack::workbench
