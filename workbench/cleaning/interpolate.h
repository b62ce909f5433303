// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Linear interpolation between the sample before the gap and the one after it. A gap at an end of the values
/// stays as it is.
inline void interpolate(std::vector<double>& values, const Interval& gap) {
  if (gap.first == 0 || gap.end >= values.size()) return;
  const double from = values[gap.first - 1];
  const double to = values[gap.end];
  const auto steps = static_cast<double>(gap.size() + 1);
  for (std::size_t i = gap.first; i < gap.end; ++i)
    values[i] = std::lerp(from, to, static_cast<double>(i - gap.first + 1) / steps);
}

}  // namespace slipstack::workbench
