// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace slipstack::workbench {

/// Standard deviation of white noise that is superimposed on a smooth signal. Sixth differences suppress the
/// smooth signal; the median of their magnitudes ignores the rare samples where it is not smooth. Zero for
/// fewer than seven samples. O(n).
double white_noise(std::span<const double> signal);

}  // namespace slipstack::workbench
