// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
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

/// Two signals recorded together, by the same method: what they have in common at each frequency. They may be
/// given in several intervals, between which nothing is known. Cost as that of two power spectra.
class CrossSpectrum {
 public:
  CrossSpectrum(double rate_Hz, std::size_t segment);

  /// An interval without gaps; the mean of each is removed. One that is shorter than a segment adds nothing.
  void add(std::span<const double> input, std::span<const double> output);

  std::size_t segments() const { return segments_; }
  std::size_t bins() const { return cross_.size(); }
  double frequency_Hz(std::size_t bin) const;
  /// Share of the output's power that follows the input linearly, 0 to 1.
  double coherence(std::size_t bin) const;
  /// Output over input, noise of the output allowed (H1).
  std::complex<double> response(std::size_t bin) const;
  /// Its relative standard deviation, sqrt((1 - c) / (2 c n)) (Bendat and Piersol, Random Data, 4th ed. 2010,
  /// 9.2.4).
  double response_deviation(std::size_t bin) const;
  /// The coherence that unrelated signals exceed with this probability, 1 - p^(1/(n - 1)) (Carter, Knapp and
  /// Nuttall 1973). One where there are fewer than two segments.
  double chance_coherence(double probability) const;

 private:
  /// Independent segments that the half-overlapping ones are worth.
  double independent_segments() const;

  double rate_Hz_;
  std::size_t segment_;
  std::size_t segments_ = 0;
  std::vector<double> input_;
  std::vector<double> output_;
  std::vector<std::complex<double>> cross_;
};

}  // namespace slipstack::workbench
