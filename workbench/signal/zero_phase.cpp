// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/zero_phase.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace slipstack::workbench {
namespace {

using std::numbers::pi;

/// Shape parameter of the Kaiser window for ripples of 94 dB (2e-5): 0.1102 (dB - 8.7), Kaiser 1974.
constexpr double kKaiser = 9.4;

constexpr std::ptrdiff_t kSideBySide = 16;  // sums of filter_all(): eight vectors of two, latency hidden

/// Input index with the ends repeated.
double at(std::span<const double> input, std::ptrdiff_t index) {
  const auto last = static_cast<std::ptrdiff_t>(input.size()) - 1;
  return input[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(index, 0, last))];
}

/// value(sample before last, before, at, next, next but one) of each sample, with the ends repeated.
template <class Value>
std::vector<double> of_five(std::span<const double> input, Value&& value) {
  std::vector<double> out(input.size());
  const auto size = static_cast<std::ptrdiff_t>(input.size());
  const auto at_end = [&](std::ptrdiff_t i) {
    out[static_cast<std::size_t>(i)] =
        value(at(input, i - 2), at(input, i - 1), at(input, i), at(input, i + 1), at(input, i + 2));
  };
  for (std::ptrdiff_t i = 0; i < std::min<std::ptrdiff_t>(2, size); ++i) at_end(i);
  const double* const from = input.data();
  for (std::ptrdiff_t i = 2; i + 2 < size; ++i)
    out[static_cast<std::size_t>(i)] = value(from[i - 2], from[i - 1], from[i], from[i + 1], from[i + 2]);
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(2, size - 2); i < size; ++i) at_end(i);
  return out;
}

}  // namespace

std::vector<double> low_pass_taps(double cutoff_Hz, double rate_Hz) {
  const double cycles_per_sample = std::min(cutoff_Hz / rate_Hz, 0.5);
  // With this length the transition band of a Kaiser window of 94 dB is cutoff/2 .. 3/2 cutoff (Kaiser 1974:
  // length = (dB - 8)/14.36 per transition). A Blackman window of the same length has ripples of 2e-4: that
  // share of the inertia force, where only one side of the fit is filtered, exceeds the noise.
  const auto half = static_cast<std::ptrdiff_t>(std::ceil(3.0 / cycles_per_sample));
  std::vector<double> taps;
  double sum = 0.0;
  for (std::ptrdiff_t k = -half; k <= half; ++k) {
    const auto offset = static_cast<double>(k);
    const double phase = offset / (static_cast<double>(half) + 1.0);
    const double window = std::cyl_bessel_i(0.0, kKaiser * std::sqrt(1.0 - phase * phase));
    const double argument = 2.0 * pi * cycles_per_sample * offset;
    const double sinc = std::abs(argument) < 1e-9 ? 1.0 : std::sin(argument) / argument;
    taps.push_back(window * sinc);
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

double noise_gain(std::span<const double> taps) {
  double sum = 0.0;
  for (const double tap : taps) sum += tap * tap;
  return sum;
}

std::vector<double> convolve(std::span<const double> a, std::span<const double> b) {
  std::vector<double> out(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  }
  return out;
}

std::vector<double> filter_all(std::span<const double> input, std::span<const double> taps) {
  const auto half = static_cast<std::ptrdiff_t>(taps.size() / 2);
  const auto count = static_cast<std::ptrdiff_t>(input.size());
  std::vector<double> out(input.size());
  const auto whole = [&](std::ptrdiff_t i) { return i >= half && i + half < count; };
  for (std::ptrdiff_t i = 0; i < count;) {
    // Sums side by side, each in the order of the taps: the compiler makes vectors of them, and every sum is
    // the one that it would be alone.
    if (whole(i) && whole(i + kSideBySide - 1)) {
      std::array<double, kSideBySide> sums{};
      const double* first = input.data() + (i - half);
      for (std::size_t k = 0; k < taps.size(); ++k) {
        for (std::size_t j = 0; j < sums.size(); ++j) sums[j] += taps[k] * first[k + j];
      }
      std::copy(sums.begin(), sums.end(), out.begin() + i);
      i += kSideBySide;
      continue;
    }
    double sum = 0.0;
    for (std::size_t k = 0; k < taps.size(); ++k)
      sum += taps[k] * at(input, i - half + static_cast<std::ptrdiff_t>(k));
    out[static_cast<std::size_t>(i++)] = sum;
  }
  return out;
}

std::vector<double> first_derivative(std::span<const double> input, double rate_Hz) {
  return of_five(input,
                 [rate_Hz](double far_before, double before, double, double behind, double far_behind) {
                   return (8.0 * (behind - before) - (far_behind - far_before)) * rate_Hz / 12.0;
                 });
}

std::vector<double> second_derivative(std::span<const double> input, double rate_Hz) {
  return of_five(
      input, [rate_Hz](double far_before, double before, double centre, double behind, double far_behind) {
        const double near = (behind - centre) + (before - centre);
        const double far = (far_behind - centre) + (far_before - centre);
        return (16.0 * near - far) * rate_Hz * rate_Hz / 12.0;
      });
}

}  // namespace slipstack::workbench
