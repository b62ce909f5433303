// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/ringing_band.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Bins of a spectrum within the bandwidth of the rows, and segments of which it is the mean. Chosen: the
/// width of a light mode above the bandwidth is then several bins, if the log is long enough.
constexpr double kMostBinsInBandwidth = 64.0;
constexpr double kLeastBinsInBandwidth = 16.0;
constexpr double kLeastSegments = 8.0;
/// What is near a frequency: within this factor. A light mode is a tenth as wide.
constexpr double kNear = 1.2;
/// Least density of what rings over that of what is near it. Of 416 training logs those where most is left
/// near the end of the known motion rise to 1.6, modes above the bandwidth rise by 5 and more.
constexpr double kLeastRise = 3.0;
/// The bandwidth over the frequency that it is to hold: a mode is known by its flanks too.
constexpr double kHolds = 1.5;

bool is_near(double frequency_Hz, double other_Hz) {
  return frequency_Hz >= other_Hz / kNear && frequency_Hz <= other_Hz * kNear;
}

/// The mean density of a signal over the parts that are long enough, by their samples.
Spectrum spectrum_of_parts(const Measurement& measurement, const std::vector<double>& signal) {
  const double rate_Hz = measurement.sample_rate_Hz();
  std::size_t longest = 0;
  for (const LogPart& part : measurement.parts()) longest = std::max(longest, part.sample_count);
  const std::size_t segment = segment_above_rows(measurement, longest);
  Spectrum mean;
  double samples = 0.0;
  for (const LogPart& part : measurement.parts()) {
    const Spectrum own =
        power_spectrum(std::span(signal).subspan(part.first_sample, part.sample_count), rate_Hz, segment);
    if (own.density.empty()) continue;
    if (mean.density.empty()) mean = {own.frequency_Hz, std::vector<double>(own.density.size(), 0.0)};
    const auto count = static_cast<double>(part.sample_count);
    for (std::size_t k = 0; k < own.density.size(); ++k) mean.density[k] += count * own.density[k];
    samples += count;
  }
  for (double& density : mean.density) density /= samples;
  return mean;
}

/// Mass, hysteresis and viscous friction; also a mass beside the declared one.
FittedModel mass_with_friction(const Measurement& measurement) {
  const auto declared_kg = measurement.parts().front().mass_kg;
  std::vector<std::string> effects = default_baseline();
  effects.push_back(effect_with_role(Role::viscous_friction).id());
  if (declared_kg && *declared_kg != 0.0) effects.push_back(effect_with_role(Role::added_mass).id());
  return fit_effects(measurement, effects, {});
}

/// What the encoder's steps make of the mass within a bandwidth, in the worst part.
double steps_N2(const Measurement& measurement, double bandwidth_Hz) {
  double most_N2 = 0.0;
  for (const LogPart& part : measurement.parts())
    most_N2 = std::max(most_N2, encoder_steps_N2(part, bandwidth_Hz, measurement.sample_rate_Hz()));
  return most_N2;
}

}  // namespace

std::size_t segment_above_rows(const Measurement& measurement, std::size_t samples) {
  const double in_bandwidth = measurement.sample_rate_Hz() / measurement.bandwidth_Hz();
  const double wanted = std::clamp(static_cast<double>(samples) / kLeastSegments,
                                   kLeastBinsInBandwidth * in_bandwidth, kMostBinsInBandwidth * in_bandwidth);
  return std::bit_floor(static_cast<std::size_t>(wanted));
}

double density_beside(const Spectrum& spectrum, std::size_t bin, std::size_t first_bin) {
  const auto k = static_cast<double>(bin);
  const auto from = std::max(first_bin, static_cast<std::size_t>(k / kNear));
  const auto to = std::min(spectrum.density.size(), static_cast<std::size_t>(std::ceil(k * kNear)) + 1);
  return median({spectrum.density.begin() + static_cast<std::ptrdiff_t>(from),
                 spectrum.density.begin() + static_cast<std::ptrdiff_t>(to)});
}

std::optional<double> bandwidth_of_ringing_Hz(const Measurement& measurement) {
  const double rate_Hz = measurement.sample_rate_Hz();
  const double above_Hz = measurement.bandwidth_Hz();
  const double known_Hz = motion_bandwidth_Hz(above_Hz, rate_Hz);
  const std::vector<double>& force_N = measurement.log().force_N;
  const Spectrum of_force = spectrum_of_parts(measurement, force_N);
  const double noise = 2.0 * squared(measurement.force_noise_N()) / rate_Hz;
  const auto is_above = [&](double frequency_Hz) {
    return frequency_Hz > above_Hz && frequency_Hz <= known_Hz;
  };
  bool excited = false;
  for (std::size_t k = 0; k < of_force.density.size(); ++k)
    excited = excited || (is_above(of_force.frequency_Hz[k]) && of_force.density[k] > 2.0 * noise);
  if (!excited) return {};

  const FittedModel model = mass_with_friction(measurement);
  std::vector<double> left_N = force_N;
  const std::vector<double>& model_N = model.linearisation->sample_force_N();
  for (std::size_t i = 0; i < left_N.size(); ++i) left_N[i] -= model_N[i];
  const Spectrum left = spectrum_of_parts(measurement, left_N);
  const double bin_Hz = left.frequency_Hz[1];
  std::vector<double> power_N2(left.density.size(), 0.0);
  double all_N2 = 0.0;
  for (std::size_t k = 0; k < power_N2.size(); ++k) {
    if (!is_above(left.frequency_Hz[k])) continue;
    power_N2[k] = bin_Hz * std::max(0.0, std::min(left.density[k], of_force.density[k]) - noise);
    all_N2 += power_N2[k];
  }
  const auto top =
      static_cast<std::size_t>(std::max_element(power_N2.begin(), power_N2.end()) - power_N2.begin());
  const double rings_Hz = left.frequency_Hz[top];
  double near_N2 = 0.0;
  for (std::size_t k = 0; k < power_N2.size(); ++k) {
    if (is_near(left.frequency_Hz[k], rings_Hz)) near_N2 += power_N2[k];
  }
  const double rise = left.density[top] / density_beside(left, top, 0);
  const bool rings = rise >= kLeastRise && 2.0 * near_N2 > all_N2 + squared(model.train_rmse_N) &&
                     near_N2 > steps_N2(measurement, kHolds * rings_Hz);
  if (!rings) return {};
  return kHolds * rings_Hz;
}

}  // namespace slipstack::workbench
