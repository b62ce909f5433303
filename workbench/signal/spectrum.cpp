// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace slipstack::workbench {
namespace {

// Half-overlapping Hann segments: the variance of a mean is 19/18 of that of as many independent ones (Welch
// 1967; the squared correlation of neighbours is 1/36).
constexpr double kOverlap = 18.0 / 19.0;

/// Transforms of windowed segments.
class SegmentTransform {
 public:
  explicit SegmentTransform(std::size_t segment) : window_(segment), windowed_(segment) {
    for (std::size_t i = 0; i < segment; ++i) {
      const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(segment);
      window_[i] = 0.5 * (1.0 - std::cos(phase));
      power_ += window_[i] * window_[i];
    }
  }
  /// Sum of the squared window.
  double power() const { return power_; }

  void of(std::span<const double> segment, double mean, std::vector<std::complex<double>>& transform) {
    for (std::size_t i = 0; i < window_.size(); ++i) windowed_[i] = (segment[i] - mean) * window_[i];
    fft_.fwd(transform, windowed_);
  }

 private:
  std::vector<double> window_;
  std::vector<double> windowed_;
  double power_ = 0.0;
  Eigen::FFT<double> fft_;
};

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

Spectrum power_spectrum(std::span<const double> input, double rate_Hz, std::size_t segment) {
  Spectrum spectrum;
  if (segment < 8 || input.size() < segment) return spectrum;
  const double mean = mean_of(input);
  const std::size_t bins = segment / 2;
  spectrum.density.assign(bins, 0.0);
  SegmentTransform transformed(segment);
  std::vector<std::complex<double>> transform;
  std::size_t segments = 0;
  for (std::size_t start = 0; start + segment <= input.size(); start += segment / 2, ++segments) {
    transformed.of(input.subspan(start, segment), mean, transform);
    for (std::size_t k = 0; k < bins; ++k) spectrum.density[k] += std::norm(transform[k]);
  }
  for (std::size_t k = 0; k < bins; ++k) {
    spectrum.frequency_Hz.push_back(static_cast<double>(k) * rate_Hz / static_cast<double>(segment));
    spectrum.density[k] *= 2.0 / (transformed.power() * rate_Hz * static_cast<double>(segments));
  }
  return spectrum;
}

CrossSpectrum::CrossSpectrum(double rate_Hz, std::size_t segment)
    : rate_Hz_(rate_Hz), segment_(segment), input_(segment / 2), output_(segment / 2), cross_(segment / 2) {}

void CrossSpectrum::add(std::span<const double> input, std::span<const double> output) {
  if (segment_ < 8 || input.size() < segment_) return;
  const double input_mean = mean_of(input);
  const double output_mean = mean_of(output);
  SegmentTransform transformed(segment_);
  std::vector<std::complex<double>> x, y;
  for (std::size_t start = 0; start + segment_ <= input.size(); start += segment_ / 2, ++segments_) {
    transformed.of(input.subspan(start, segment_), input_mean, x);
    transformed.of(output.subspan(start, segment_), output_mean, y);
    for (std::size_t k = 0; k < bins(); ++k) {
      input_[k] += std::norm(x[k]);
      output_[k] += std::norm(y[k]);
      cross_[k] += std::conj(x[k]) * y[k];
    }
  }
}

double CrossSpectrum::frequency_Hz(std::size_t bin) const {
  return static_cast<double>(bin) * rate_Hz_ / static_cast<double>(segment_);
}

double CrossSpectrum::coherence(std::size_t bin) const {
  const double power = input_[bin] * output_[bin];
  return power > 0.0 ? std::min(1.0, std::norm(cross_[bin]) / power) : 0.0;
}

std::complex<double> CrossSpectrum::response(std::size_t bin) const {
  return cross_[bin] / std::max(input_[bin], 1e-300);
}

double CrossSpectrum::independent_segments() const {
  return kOverlap * static_cast<double>(segments_);
}

double CrossSpectrum::response_deviation(std::size_t bin) const {
  const double shared = std::max(coherence(bin), 1e-12);
  return std::sqrt((1.0 - shared) / (2.0 * shared * std::max(independent_segments(), 1.0)));
}

double CrossSpectrum::chance_coherence(double probability) const {
  const double degrees = independent_segments() - 1.0;
  return degrees > 0.5 ? 1.0 - std::pow(probability, 1.0 / degrees) : 1.0;
}

}  // namespace slipstack::workbench
