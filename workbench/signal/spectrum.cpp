// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/spectrum.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace slipstack::workbench {

Spectrum power_spectrum(std::span<const double> input, double rate_Hz, std::size_t segment) {
  Spectrum spectrum;
  if (segment < 8 || input.size() < segment) return spectrum;
  std::vector<double> window(segment);
  double power = 0.0;
  for (std::size_t i = 0; i < segment; ++i) {
    const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(segment);
    window[i] = 0.5 * (1.0 - std::cos(phase));
    power += window[i] * window[i];
  }
  double mean = 0.0;
  for (const double value : input) mean += value;
  mean /= static_cast<double>(input.size());

  const std::size_t bins = segment / 2;
  spectrum.density.assign(bins, 0.0);
  Eigen::FFT<double> fft;
  std::vector<double> windowed(segment);
  std::vector<std::complex<double>> transform;
  std::size_t segments = 0;
  for (std::size_t start = 0; start + segment <= input.size(); start += segment / 2, ++segments) {
    for (std::size_t i = 0; i < segment; ++i) windowed[i] = (input[start + i] - mean) * window[i];
    fft.fwd(transform, windowed);
    for (std::size_t k = 0; k < bins; ++k) spectrum.density[k] += std::norm(transform[k]);
  }
  for (std::size_t k = 0; k < bins; ++k) {
    spectrum.frequency_Hz.push_back(static_cast<double>(k) * rate_Hz / static_cast<double>(segment));
    spectrum.density[k] *= 2.0 / (power * rate_Hz * static_cast<double>(segments));
  }
  return spectrum;
}

}  // namespace slipstack::workbench
