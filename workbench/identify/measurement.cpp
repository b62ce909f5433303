// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/measurement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "workbench/identify/dequantise.h"
#include "workbench/identify/spectrum.h"
#include "workbench/identify/zero_phase.h"
#include "workbench/log/median.h"

namespace slipstack::workbench {
namespace {

/// The motion keeps this much more bandwidth than the rows, so that what is non-linear in it (signs, slip,
/// exponentials of speed) is formed before the common filter and not after.
constexpr double kMotionBandwidthRatio = 3.0;

/// Hysteresis is driven by displacement as it is, where it lies on an encoder's grid: a filter with a sharp
/// edge overshoots by nanometres where a move ends, and to hysteresis that is a reversal. Readings on no grid
/// carry noise instead, which is as bad; these taps are positive, so that they make no reversal of their own.
constexpr std::array<double, 5> kDisplacementTaps{1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0};

/// Rows per period of the bandwidth: above the Nyquist density, so nothing is lost.
constexpr double kRowsPerCycle = 3.0;

/// Highest bandwidth of the rows, relative to the sampling rate: a motion is sampled well where its own
/// frequencies are twenty times lower.
constexpr double kHighestBandwidth = 0.05;

constexpr int kFolds = 5;
constexpr int kBlocksPerFold = 6;

/// Standard deviation of white noise under a smooth signal: sixth differences kill what a motion leaves at
/// the highest frequencies; their median is blind to the rare samples where it does not.
double white_noise(std::span<const double> signal) {
  constexpr double kGain = 30.397368307141326;  // sqrt(924), 924 = sum of squares of (1 -6 15 -20 15 -6 1)
  std::vector<double> differences;
  differences.reserve(signal.size());
  for (std::size_t i = 3; i + 3 < signal.size(); ++i) {
    const double d = (signal[i - 3] + signal[i + 3]) - 6.0 * (signal[i - 2] + signal[i + 2]) +
                     15.0 * (signal[i - 1] + signal[i + 1]) - 20.0 * signal[i];
    differences.push_back(std::abs(d));
  }
  if (differences.empty()) return 0.0;
  return median(std::move(differences)) / 0.67448975 / kGain;
}

/// Mass and velocity terms by plain least squares on a strongly smoothed log: only good for choosing filters.
double quick_mass(const Log& log) {
  const std::vector<double> taps = low_pass_taps(0.02 * log.sample_rate_Hz, log.sample_rate_Hz);
  const std::vector<double> x = filter_all(log.position_m, taps);
  const std::vector<double> f = filter_all(log.force_N, taps);
  const std::vector<double> v = first_derivative(x, log.sample_rate_Hz);
  const std::vector<double> a = second_derivative(x, log.sample_rate_Hz);
  Eigen::Matrix4d gram = 1e-12 * Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector4d row(a[i], v[i], std::copysign(1.0, v[i]), 1.0);
    gram += row * row.transpose();
    right += row * f[i];
  }
  return std::max(0.0, gram.ldlt().solve(right)(0));
}

std::vector<double> motion_taps(double bandwidth_Hz, double rate_Hz) {
  return low_pass_taps(std::min(kMotionBandwidthRatio * bandwidth_Hz, 0.3 * rate_Hz), rate_Hz);
}

}  // namespace

Measurement::Measurement(Log log, const ConditioningOptions& options) : log_(std::move(log)) {
  encoder_resolution_m_ = log_.encoder_resolution_m.value_or(0.0);
  rough_mass_kg_ = log_.mass_kg ? *log_.mass_kg : quick_mass(log_);
  force_noise_N_ = white_noise(log_.force_N);
  choose_bandwidth(options.bandwidth_Hz);
  motion_ = estimate_motion(log_.position_m);
  find_unknown_start();
  choose_rows(options.maximum_rows);
}

void Measurement::choose_bandwidth(double wished_Hz) {
  const double rate = sample_rate_Hz();
  const double highest = kHighestBandwidth * rate;
  if (wished_Hz > 0.0) {
    bandwidth_Hz_ = std::min(wished_Hz, 0.25 * rate);
    return;
  }
  // Quantisation seen through the mass grows with the square of frequency: stop where, summed over the band,
  // it equals the noise of the force.
  double limit = highest;
  const double quantisation_N = rough_mass_kg_ * encoder_resolution_m_ / std::sqrt(12.0);
  if (quantisation_N > 0.0 && force_noise_N_ > 0.0) {
    const double omega2 = force_noise_N_ / quantisation_N * std::sqrt(5.0);
    limit = std::min(limit, std::sqrt(omega2) / (2.0 * std::numbers::pi));
  }
  // Nor beyond what the motion excites.
  const Spectrum spectrum = power_spectrum(log_.force_N, rate, 512);
  double excited = highest;
  if (!spectrum.density.empty()) {
    const double floor = 2.0 * force_noise_N_ * force_noise_N_ / rate;
    std::size_t last = spectrum.density.size() - 1;
    while (last > 0 && spectrum.density[last] < 2.0 * floor) --last;
    excited = spectrum.frequency_Hz[last];
  }
  const double least = std::min(highest, 0.01 * rate);
  bandwidth_Hz_ = std::clamp(std::min(limit, excited), least, highest);
}

Measurement::Motion Measurement::estimate_motion(const std::vector<double>& reading_m) const {
  const double rate = sample_rate_Hz();
  const std::vector<double> position = dequantise(reading_m, encoder_resolution_m_);
  Motion motion;
  motion.displacement_m = encoder_resolution_m_ > 0.0 ? position : filter_all(position, kDisplacementTaps);
  motion.position_m = filter_all(position, motion_taps(bandwidth_Hz_, rate));
  motion.velocity_mps = first_derivative(motion.position_m, rate);
  motion.acceleration_mps2 = second_derivative(motion.position_m, rate);
  return motion;
}

void Measurement::find_unknown_start() {
  const auto [low, high] = std::minmax_element(position_m().begin(), position_m().end());
  const double needed = std::min(2.0 * kLongestSlip_m, 0.95 * (*high - *low));
  double lowest = position_m().front();
  double highest = lowest;
  for (std::size_t i = 0; i < sample_count() / 4; ++i) {
    lowest = std::min(lowest, position_m()[i]);
    highest = std::max(highest, position_m()[i]);
    if (highest - lowest >= needed) {
      unknown_start_ = i;
      return;
    }
  }
}

void Measurement::choose_rows(std::size_t maximum_rows) {
  const double rate = sample_rate_Hz();
  filter_ = RowFilter(bandwidth_Hz_, rate);
  const std::size_t group = filter_.group();
  const std::size_t margin = filter_.taps().size() / 2 + motion_taps(bandwidth_Hz_, rate).size() / 2 + 2;
  const std::size_t count = sample_count();
  const std::size_t begin = unknown_start_ + margin;
  const std::size_t usable = count > begin + margin ? count - margin - begin : 0;
  row_stride_ = std::max<std::size_t>(1, static_cast<std::size_t>(rate / (kRowsPerCycle * bandwidth_Hz_)));
  row_stride_ = std::max(row_stride_, (usable + maximum_rows - 1) / maximum_rows);
  row_stride_ = (row_stride_ + group - 1) / group * group;
  const std::size_t first = (begin + group - 1) / group * group + group / 2;
  for (std::size_t i = first; i < begin + usable; i += row_stride_) row_samples_.push_back(i);

  fold_count_ = kFolds;
  block_count_ = kFolds * kBlocksPerFold;
  const std::size_t rows = row_samples_.size();
  row_weights_ = Eigen::VectorXd::Ones(row_count());
  for (std::size_t row = 0; row < rows; ++row) {
    row_blocks_.push_back(static_cast<int>(row * static_cast<std::size_t>(block_count_) / rows));
  }
}

double Measurement::weighted_rms(const Eigen::VectorXd& rows) const {
  return std::sqrt(row_weights_.dot(rows.cwiseAbs2()) / row_weights_.sum());
}

Sample<double> Measurement::sample(std::size_t index) const {
  Sample<double> sample;
  sample.time_s = static_cast<double>(index) * tick_s();
  sample.displacement = motion_.displacement_m[index];
  sample.position_m = motion_.position_m[index];
  sample.velocity_mps = motion_.velocity_mps[index];
  sample.acceleration_mps2 = motion_.acceleration_mps2[index];
  return sample;
}

Eigen::VectorXd Measurement::filtered(std::span<const double> signal) const {
  RowCollector collector(filter_, row_samples_, 1);
  for (std::size_t first = 0; first < signal.size(); first += collector.chunk()) {
    const std::size_t count = std::min(collector.chunk(), signal.size() - first);
    std::copy_n(signal.begin() + static_cast<std::ptrdiff_t>(first), count, collector.space(0));
    collector.commit(count);
  }
  return collector.take().col(0);
}

Eigen::VectorXd Measurement::force_N(double delay_s) const {
  if (delay_s == 0.0) return filtered(log_.force_N);
  // Later by whole samples, then by the rest with the cubic through four of them.
  const double samples = delay_s * sample_rate_Hz();
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(samples));
  const double u = samples - static_cast<double>(whole);
  const std::array<double, 4> weight{-u * (u - 1.0) * (u - 2.0) / 6.0,
                                     (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0,
                                     -(u + 1.0) * u * (u - 2.0) / 2.0, (u + 1.0) * u * (u - 1.0) / 6.0};
  const auto count = static_cast<std::ptrdiff_t>(sample_count());
  std::vector<double> later(sample_count());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    double sum = 0.0;
    for (std::ptrdiff_t k = 0; k < 4; ++k) {
      const auto index = std::clamp<std::ptrdiff_t>(i + whole + k - 1, 0, count - 1);
      sum += weight[static_cast<std::size_t>(k)] * log_.force_N[static_cast<std::size_t>(index)];
    }
    later[static_cast<std::size_t>(i)] = sum;
  }
  return filtered(later);
}

double Measurement::acceleration_noise_mps2() const {
  std::size_t moving = 0;
  for (std::size_t i = 1; i < sample_count(); ++i)
    moving += log_.position_m[i] != log_.position_m[i - 1] ? 1 : 0;
  const double share = static_cast<double>(moving) / static_cast<double>(sample_count());
  const std::vector<double> both = convolve(motion_taps(bandwidth_Hz_, sample_rate_Hz()), filter_.taps());
  const double gain = noise_gain(second_derivative(both, sample_rate_Hz()));
  return encoder_resolution_m_ * std::sqrt(share * gain / 12.0);
}

double Measurement::filtered_force_noise_N() const {
  return force_noise_N_ * std::sqrt(noise_gain(filter_.taps()));
}

Measurement Measurement::requantised(double shift_steps) const {
  Measurement copy = *this;
  if (encoder_resolution_m_ <= 0.0) return copy;
  std::vector<double> reading = motion_.displacement_m;
  for (double& x : reading) {
    x = (std::floor(x / encoder_resolution_m_ + shift_steps) + 0.5 - shift_steps) * encoder_resolution_m_;
  }
  copy.motion_.displacement_m = copy.estimate_motion(reading).displacement_m;
  return copy;
}

}  // namespace slipstack::workbench
