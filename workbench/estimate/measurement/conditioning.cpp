// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/conditioning.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "workbench/base/statistics.h"
#include "workbench/signal/spectrum.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// The bandwidth within which the encoder's quantisation, differentiated twice and multiplied by the mass,
/// has the same power as the noise of the force. Its density grows with the fourth power of frequency.
double band_above_quantisation_Hz(const LogPart& part) {
  const double quantisation_N = part.rough_mass_kg * part.encoder_resolution_m / std::sqrt(12.0);
  if (!(quantisation_N > 0.0) || !(part.force_noise_N > 0.0)) return std::numeric_limits<double>::infinity();
  const double omega2 = part.force_noise_N / quantisation_N * std::sqrt(5.0);
  return std::sqrt(omega2) / (2.0 * std::numbers::pi);
}

/// The share of the force (standard deviation) that the encoder's steps may be within the least bandwidth.
/// Chosen: where they were 12 %, a payload of 30 % was below the noise floor.
constexpr double kStepsOfForce = 0.02;
/// The least bandwidth, relative to the sampling rate: the second where the encoder's steps are small there,
/// else where they become small, but never below the first, whose filters are some thousand samples long.
constexpr double kLowestBandwidth = 0.001;
constexpr double kSufficientBandwidth = 0.01;

double standard_deviation(std::span<const double> values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  return std::sqrt(std::transform_reduce(values.begin(), values.end(), 0.0, std::plus<>(),
                                         [mean](double value) { return squared(value - mean); }) /
                   count);
}

/// The bandwidth within which the encoder's steps are kStepsOfForce of the force: their mean square grows
/// with the fifth power of it.
double band_of_small_steps_Hz(const LogPart& part, std::span<const double> force_N, double rate_Hz) {
  const double within_1_Hz_N2 = encoder_steps_N2(part, 1.0, rate_Hz);
  if (!(within_1_Hz_N2 > 0.0)) return std::numeric_limits<double>::infinity();
  return std::pow(squared(kStepsOfForce * standard_deviation(force_N)) / within_1_Hz_N2, 0.2);
}

/// Highest frequency at which the force is stronger than its noise; `unknown_Hz` where the log is too short.
double excited_Hz(std::span<const double> force_N, double rate_Hz, double noise_N, double unknown_Hz) {
  const Spectrum spectrum = power_spectrum(force_N, rate_Hz, 512);
  if (spectrum.density.empty()) return unknown_Hz;
  const double floor = 2.0 * noise_N * noise_N / rate_Hz;
  std::size_t last = spectrum.density.size() - 1;
  while (last > 0 && spectrum.density[last] < 2.0 * floor) --last;
  return spectrum.frequency_Hz[last];
}

/// The motion keeps this many times the bandwidth of the rows, so that what is non-linear in it (signs, slip,
/// exponentials of speed) is formed before the common filter and not after.
constexpr double kMotionBandwidthRatio = 3.0;

/// A log is compared at three instants for each period of the bandwidth, and a fit needs a hundred of them
/// (checks.cpp). The filters' margins and the burn-in take up to half of a short log, so its bandwidth is not
/// less than gives this many, even where quantisation then exceeds the noise of a force with very little
/// noise.
constexpr double kLeastInstants = 200.0;
constexpr double kInstantsPerPeriod = 3.0;

}  // namespace

double motion_bandwidth_Hz(double bandwidth_Hz, double rate_Hz) {
  return std::min(kMotionBandwidthRatio * bandwidth_Hz, 0.3 * rate_Hz);
}

std::vector<double> motion_taps(double bandwidth_Hz, double rate_Hz) {
  return low_pass_taps(motion_bandwidth_Hz(bandwidth_Hz, rate_Hz), rate_Hz);
}

double encoder_steps_N2(const LogPart& part, double bandwidth_Hz, double rate_Hz) {
  const double step_N =
      part.rough_mass_kg * part.encoder_resolution_m * squared(2.0 * std::numbers::pi * bandwidth_Hz);
  return squared(step_N) / 12.0 / 5.0 * 2.0 * bandwidth_Hz / rate_Hz;
}

double bandwidth_of_enough_rows_Hz(double duration_s) {
  return kLeastInstants / (kInstantsPerPeriod * duration_s);
}

double bandwidth_shown_Hz(const Log& log, const std::vector<LogPart>& parts) {
  const double rate = log.sample_rate_Hz;
  const double highest = kHighestBandwidth * rate;
  double limit = highest;
  double excited = 0.0;
  double sufficient = kSufficientBandwidth * rate;
  for (const LogPart& part : parts) {
    limit = std::min(limit, band_above_quantisation_Hz(part));
    const std::span<const double> force_N =
        std::span(log.force_N).subspan(part.first_sample, part.sample_count);
    excited = std::max(excited, excited_Hz(force_N, rate, part.force_noise_N, highest));
    sufficient = std::min(sufficient, band_of_small_steps_Hz(part, force_N, rate));
  }
  const double duration_s = static_cast<double>(log.position_m.size()) / rate;
  const double lowest = std::max(kLowestBandwidth * rate, bandwidth_of_enough_rows_Hz(duration_s));
  const double least = std::min(highest, std::max(lowest, sufficient));
  return std::clamp(std::min(limit, excited), least, highest);
}

}  // namespace slipstack::workbench
