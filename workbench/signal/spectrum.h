// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace slipstack::workbench {

struct Spectrum {
  std::vector<double> frequency_Hz;
  std::vector<double> density;  ///< one-sided power spectral density, input unit squared per Hz
};

/// Welch's method (1967): Hann windows of `segment` samples (a power of two), half overlapping, mean removed.
/// Cost O(n log segment). Empty when the input is shorter than one segment.
Spectrum power_spectrum(std::span<const double> input, double rate_Hz, std::size_t segment);

}  // namespace slipstack::workbench
