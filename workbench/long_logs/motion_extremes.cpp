// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/motion_extremes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "workbench/signal/noise_estimate.h"

namespace slipstack::workbench {
namespace {

/// Windows of 1, 2, 4 ... half periods of the bandwidth; beyond the last, moves of an axis are averaged away.
constexpr int kWindows = 5;
/// Standard deviations of noise that are subtracted: Gaussian noise exceeds five in one of 10^6 samples.
constexpr double kDeviations = 5.0;

/// Sums of the first values, from which every mean over a window follows.
std::vector<double> running_sums(const std::vector<double>& values, std::size_t first, std::size_t end) {
  std::vector<double> sums{0.0};
  sums.reserve(end - first + 1);
  for (std::size_t i = first; i < end; ++i) sums.push_back(sums.back() + (values[i] - values[first]));
  return sums;
}

/// The extremes over the windows of `n` samples that begin at the first `count` samples of an interval.
class Windows {
 public:
  Windows(const Measurement& measurement, std::size_t first, std::size_t end, double noise_m)
      : position_m_(running_sums(measurement.log().position_m, first, end)),
        force_N_(running_sums(measurement.log().force_N, first, end)),
        first_m_(measurement.log().position_m[first]),
        first_N_(measurement.log().force_N[first]),
        tick_s_(measurement.tick_s()),
        noise_m_(noise_m),
        half_step_m_(0.5 * measurement.encoder_resolution_m()),
        noise_N_(measurement.force_noise_N()) {}

  MotionExtremes of(std::size_t n, std::size_t count) const {
    MotionExtremes found;
    const auto samples = static_cast<double>(n);
    for (std::size_t i = 0; i < count && i + n < position_m_.size(); ++i) {
      const double x_m = first_m_ + mean(position_m_, i, n);
      found.low_m = std::min(found.low_m, x_m);
      found.high_m = std::max(found.high_m, x_m);
      found.force_N = std::max(found.force_N, std::abs(first_N_ + mean(force_N_, i, n)));
    }
    found.force_N -= kDeviations * noise_N_ / std::sqrt(samples);
    found.velocity_mps = largest_difference({-1.0, 1.0}, n, count);
    found.acceleration_mps2 = largest_difference({1.0, -2.0, 1.0}, n, count);
    found.jerk_mps3 = largest_difference({-1.0, 3.0, -3.0, 1.0}, n, count);
    return found;
  }

 private:
  static double mean(const std::vector<double>& sums, std::size_t from, std::size_t n) {
    return (sums[from + n] - sums[from]) / static_cast<double>(n);
  }

  double largest_difference(const std::vector<double>& weights, std::size_t n, std::size_t count) const {
    double largest_m = 0.0;
    double squares = 0.0;
    double magnitudes = 0.0;
    for (const double weight : weights) {
      squares += weight * weight;
      magnitudes += std::abs(weight);
    }
    for (std::size_t i = 0; i < count && i + weights.size() * n < position_m_.size(); ++i) {
      double difference_m = 0.0;
      for (std::size_t k = 0; k < weights.size(); ++k) {
        difference_m += weights[k] * mean(position_m_, i + k * n, n);
      }
      largest_m = std::max(largest_m, std::abs(difference_m));
    }
    const auto samples = static_cast<double>(n);
    const double error_m = kDeviations * noise_m_ * std::sqrt(squares / samples) + magnitudes * half_step_m_;
    const double window_s = samples * tick_s_;
    return std::max(0.0, largest_m - error_m) / std::pow(window_s, static_cast<double>(weights.size() - 1));
  }

  std::vector<double> position_m_;
  std::vector<double> force_N_;
  double first_m_;
  double first_N_;
  double tick_s_;
  double noise_m_;
  double half_step_m_;
  double noise_N_;
};

}  // namespace

void MotionExtremes::add(const MotionExtremes& other) {
  low_m = std::min(low_m, other.low_m);
  high_m = std::max(high_m, other.high_m);
  velocity_mps = std::max(velocity_mps, other.velocity_mps);
  acceleration_mps2 = std::max(acceleration_mps2, other.acceleration_mps2);
  jerk_mps3 = std::max(jerk_mps3, other.jerk_mps3);
  force_N = std::max(force_N, other.force_N);
}

void MotionExtremes::take(const Measurement& measurement, std::size_t first, std::size_t end) {
  const double half_period = 0.5 * measurement.sample_rate_Hz() / measurement.bandwidth_Hz();
  const auto shortest = static_cast<std::size_t>(std::max(2.0, std::round(half_period)));
  const double noise_m = white_noise(measurement.log().position_m);
  for (const LogPart& part : measurement.parts()) {
    for (const Interval& interval : usable_intervals(part, 0)) {
      const std::size_t from = std::max(first, part.first_sample + interval.first);
      const std::size_t until = std::min(end, part.first_sample + interval.end);
      if (from >= until) continue;
      const std::size_t reach = 4 * (shortest << (kWindows - 1));
      const Windows windows(measurement, from, std::min(part.first_sample + interval.end, until + reach),
                            noise_m);
      for (int w = 0; w < kWindows; ++w) add(windows.of(shortest << w, until - from));
    }
  }
}

}  // namespace slipstack::workbench
