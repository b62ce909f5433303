// SPDX-License-Identifier: Apache-2.0
// The force of a measurement at its rows, and its noise.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {

double Measurement::weighted_rms(const Eigen::VectorXd& rows) const {
  return std::sqrt(row_weights_.dot(rows.cwiseAbs2()) / row_weights_.sum());
}

Eigen::VectorXd Measurement::filtered(std::span<const double> signal) const {
  RowCollector collector(filter_, row_samples_, 1);
  for (std::size_t first = 0; first < signal.size(); first += collector.chunk()) {
    const std::size_t count = std::min(collector.chunk(), signal.size() - first);
    std::copy_n(signal.begin() + static_cast<std::ptrdiff_t>(first), count, collector.space());
    collector.commit(count);
  }
  return collector.take().col(0);
}

Eigen::VectorXd Measurement::force_N(const MeasurementDynamics& lag) const {
  if (lag.delay_s == 0.0 && lag.filter_s == 0.0) return *recorded_force_N_;
  // The delay in whole samples, then the rest by cubic interpolation through four of them.
  const double samples = lag.delay_s * sample_rate_Hz();
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(samples));
  const double u = samples - static_cast<double>(whole);
  const std::array<double, 4> weight{-u * (u - 1.0) * (u - 2.0) / 6.0,
                                     (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0,
                                     -(u + 1.0) * u * (u - 2.0) / 2.0, (u + 1.0) * u * (u - 1.0) / 6.0};
  std::vector<double> later(sample_count());
  for (const LogPart& part : parts_) {
    const auto first = static_cast<std::ptrdiff_t>(part.first_sample);
    const auto end = static_cast<std::ptrdiff_t>(part.end_sample());
    const double* const recorded_N = log_->force_N.data();
    const auto interpolated_N = [&](const auto& at) {
      return ((weight[0] * at(-1) + weight[1] * at(0)) + weight[2] * at(1)) + weight[3] * at(2);
    };
    // Where the four samples lie within the part no index needs a look, so that several are computed at once.
    const std::ptrdiff_t inner = std::clamp(first + 1 - whole, first, end);
    const std::ptrdiff_t outer = std::clamp(end - 2 - whole, inner, end);
    const auto at_ends = [&](std::ptrdiff_t i) {
      later[static_cast<std::size_t>(i)] = interpolated_N([&](std::ptrdiff_t k) {
        return recorded_N[std::clamp<std::ptrdiff_t>(i + whole + k, first, end - 1)];
      });
    };
    for (std::ptrdiff_t i = first; i < inner; ++i) at_ends(i);
    for (std::ptrdiff_t i = inner; i < outer; ++i) {
      const double* const from = recorded_N + i + whole;
      later[static_cast<std::size_t>(i)] = interpolated_N([from](std::ptrdiff_t k) { return from[k]; });
    }
    for (std::ptrdiff_t i = outer; i < end; ++i) at_ends(i);
    if (lag.filter_s == 0.0) continue;
    const std::span<double> own(later.data() + first, static_cast<std::size_t>(end - first));
    const std::vector<double> slope = first_derivative(own, sample_rate_Hz());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] += lag.filter_s * slope[i];
  }
  return filtered(later);
}

double Measurement::force_noise_gain(const MeasurementDynamics& lag) const {
  const double plain = noise_gain(filter_.taps());
  if (lag.filter_s == 0.0) return std::sqrt(plain);
  // The taps are even and their derivative is odd, so the two are orthogonal and their powers add up.
  const double slope = noise_gain(first_derivative(filter_.taps(), sample_rate_Hz()));
  return std::sqrt(plain + lag.filter_s * lag.filter_s * slope);
}

double Measurement::position_noise_m_per_root_Hz(const LogPart& part) const {
  std::size_t moving = 0;
  for (std::size_t i = part.first_sample + 1; i < part.end_sample(); ++i)
    moving += log_->position_m[i] != log_->position_m[i - 1] ? 1 : 0;
  const double share = static_cast<double>(moving) / static_cast<double>(part.sample_count);
  return part.encoder_resolution_m * std::sqrt(share / 12.0 * 2.0 / sample_rate_Hz());
}

double Measurement::acceleration_noise_mps2(const LogPart& part) const {
  const std::vector<double> both = convolve(motion_taps(bandwidth_Hz_, sample_rate_Hz()), filter_.taps());
  const double gain = noise_gain(second_derivative(both, sample_rate_Hz()));
  return position_noise_m_per_root_Hz(part) * std::sqrt(0.5 * sample_rate_Hz() * gain);
}

double Measurement::force_noise_N() const {
  double sum = 0.0;
  for (const LogPart& part : parts_) {
    sum += static_cast<double>(part.sample_count) * part.force_noise_N * part.force_noise_N;
  }
  return std::sqrt(sum / static_cast<double>(sample_count()));
}

const Eigen::VectorXd& Measurement::noise_variance() const {
  if (noise_variance_.size() == 0)
    throw std::logic_error("the noise of the rows is asked for before weigh_rows()");
  return noise_variance_;
}

double Measurement::noise_floor_N() const {
  return std::sqrt(row_weights_.dot(noise_variance()) / row_weights_.sum());
}

double Measurement::noise_floor_of_log_N(std::size_t log) const {
  const RowRange own = rows_of_log(log);
  const Eigen::VectorXd weights = row_weights_.segment(own.first, own.count);
  return std::sqrt(weights.dot(noise_variance().segment(own.first, own.count)) / weights.sum());
}

double Measurement::filtered_force_noise_N() const {
  return force_noise_N() * force_noise_gain({});
}

}  // namespace slipstack::workbench
