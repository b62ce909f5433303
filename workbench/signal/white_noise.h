// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace slipstack::workbench {

/// Standard deviation of white noise under a smooth signal: sixth differences kill what a motion leaves at
/// the highest frequencies; their median is blind to the rare samples where it does not. Zero for fewer than
/// seven samples. O(n).
double white_noise(std::span<const double> signal);

}  // namespace slipstack::workbench
