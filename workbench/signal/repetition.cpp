// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/repetition.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numeric>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace slipstack::workbench {
namespace {

/// A motion and its repetition by a controller differ by less; two different motions of one axis do not.
/// Chosen.
constexpr double kSame = 0.98;
/// Between a signal and its repetition the correlation falls below this. Chosen.
constexpr double kOther = 0.5;

std::vector<double> without_mean(std::span<const double> signal) {
  const double mean = std::accumulate(signal.begin(), signal.end(), 0.0) / static_cast<double>(signal.size());
  std::vector<double> values(signal.begin(), signal.end());
  for (double& value : values) value -= mean;
  return values;
}

/// Correlation of the signal with itself `lag` samples later.
double correlation(const std::vector<double>& values, std::size_t lag) {
  double product = 0.0, first = 1e-300, later = 1e-300;
  for (std::size_t i = 0; i + lag < values.size(); ++i) {
    product += values[i] * values[i + lag];
    first += values[i] * values[i];
    later += values[i + lag] * values[i + lag];
  }
  return product / std::sqrt(first * later);
}

/// About the same for each lag up to half of the signal, by its spectrum.
std::vector<double> correlations(const std::vector<double>& values) {
  const std::size_t count = values.size();
  std::vector<double> padded(std::bit_ceil(2 * count), 0.0);
  std::copy(values.begin(), values.end(), padded.begin());
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, padded);
  for (auto& bin : spectrum) bin = std::norm(bin);
  std::vector<double> products;
  transform.inv(products, spectrum);
  std::vector<double> energy{0.0};  // of the first samples
  for (const double value : values) energy.push_back(energy.back() + value * value);
  std::vector<double> all(count / 2);
  for (std::size_t lag = 0; lag < all.size(); ++lag) {
    const double both = energy[count - lag] * (energy[count] - energy[lag]);
    all[lag] = products[lag] / std::sqrt(std::max(both, 1e-300));
  }
  return all;
}

/// The lag of the largest correlation next to `lag`, by the parabola through three.
double refined(const std::vector<double>& values, std::size_t lag) {
  while (lag > 1 && correlation(values, lag - 1) > correlation(values, lag)) --lag;
  while (lag + 2 < values.size() && correlation(values, lag + 1) > correlation(values, lag)) ++lag;
  const double before = correlation(values, lag - 1);
  const double at = correlation(values, lag);
  const double after = correlation(values, lag + 1);
  const double curvature = before - 2.0 * at + after;
  const double beside = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
  return static_cast<double>(lag) + std::clamp(beside, -0.5, 0.5);
}

}  // namespace

double repetition_period(std::span<const double> signal) {
  if (signal.size() < 16) return 0.0;
  const std::vector<double> values = without_mean(signal);
  const std::vector<double> all = correlations(values);
  std::size_t lag = 1;
  while (lag < all.size() && all[lag] > kOther) ++lag;
  while (lag < all.size() && all[lag] < kSame) ++lag;
  if (3 * lag > signal.size()) return 0.0;
  double period = refined(values, lag);
  // The longest multiple of which a third of the signal is left has the smallest error.
  for (double times = 2.0; times * period < 0.67 * static_cast<double>(values.size()); times *= 2.0)
    period = refined(values, static_cast<std::size_t>(std::lround(times * period))) / times;
  return period;
}

}  // namespace slipstack::workbench
