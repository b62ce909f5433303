// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Standard deviation of white noise that is superimposed on a smooth signal. Sixth differences suppress the
/// smooth signal; the median of their magnitudes ignores the rare samples where it is not smooth. Zero for
/// fewer than seven samples. `left_out`: intervals in ascending order that say nothing of the noise, as a
/// signal at the limit of its sensor. O(n).
double white_noise(std::span<const double> signal, const std::vector<Interval>& left_out = {});

}  // namespace slipstack::workbench
