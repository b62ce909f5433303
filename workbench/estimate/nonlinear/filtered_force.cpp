// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/filtered_force.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <vector>

#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/signal/noise_estimate.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// The amplitude to which a filter must be seen to fall. Chosen far below what a rotor without its load, or a
/// friction of another form, may leave of the force.
constexpr double kFallen = 0.1;
constexpr double kHalf = 0.5;
/// What a filter takes from the amplitude at the end of the band, at most.
constexpr double kTaken = 0.02;
/// The probability by which coherence counts as chance.
constexpr double kChance = 1e-3;

/// Less noise than this, of the rms of the force, has no sensor: it is the rounding of a text.
constexpr double kNoSensor = 1e-5;

/// Whether neighbouring samples share their noise, or have none.
bool may_be_filtered(const Measurement& measurement) {
  const std::vector<double>& force_N = measurement.log().force_N;
  double squares = 0.0;
  for (const double force : force_N) squares += force * force;
  return growth_of_noise_at_half_rate(force_N) >= kNotWhite ||
         measurement.force_noise_N() < kNoSensor * std::sqrt(squares / static_cast<double>(force_N.size()));
}

/// The ratio of the force to the model at one frequency.
struct Ratio {
  double frequency_Hz = 0.0;
  double amplitude = 0.0;
};

/// The ratio at all frequencies where both have something in common, with the noise of the model allowed
/// (H2; Bendat and Piersol, Random Data, 4th ed. 2010, 6.2): that of the encoder does not lower it. Of
/// samples, because a filter may fall above the band of the rows; up to where the motion of the model ends.
std::vector<Ratio> ratios_of(const Measurement& measurement, const FittedModel& model) {
  const auto rows = static_cast<std::size_t>(measurement.row_count());
  const std::size_t in_rows = std::clamp<std::size_t>(std::bit_floor(rows / 8), 64, 256);
  CrossSpectrum spectrum(measurement.sample_rate_Hz(), std::bit_floor(in_rows * measurement.row_stride()));
  const std::vector<double>& model_N = model.linearisation->sample_force_N();
  const std::vector<double>& measured_N = measurement.log().force_N;
  for (const LogPart& part : measurement.parts())
    spectrum.add({model_N.data() + part.first_sample, part.sample_count},
                 {measured_N.data() + part.first_sample, part.sample_count});
  const double known_Hz = motion_bandwidth_Hz(measurement.bandwidth_Hz(), measurement.sample_rate_Hz());
  std::vector<Ratio> ratios;
  if (spectrum.segments() < 2) return ratios;
  const double chance = spectrum.chance_coherence(kChance);
  for (std::size_t bin = 2; bin < spectrum.bins(); ++bin) {  // a Hann window spreads the mean to the first
    if (spectrum.frequency_Hz(bin) > known_Hz) break;
    if (spectrum.coherence(bin) <= chance) continue;
    ratios.push_back(
        {spectrum.frequency_Hz(bin), std::abs(spectrum.response(bin)) / spectrum.coherence(bin)});
  }
  return ratios;
}

/// The frequency from which on the ratio stays below `amplitude`; zero where it does not.
double falls_below_at_Hz(const std::vector<Ratio>& ratios, double amplitude) {
  auto last_above = std::find_if(ratios.rbegin(), ratios.rend(),
                                 [&](const Ratio& one) { return one.amplitude >= amplitude; });
  if (last_above == ratios.rend() || last_above == ratios.rbegin()) return 0.0;
  return std::prev(last_above)->frequency_Hz;
}

}  // namespace

std::optional<ForceFilter> filter_of_force(const Measurement& measurement) {
  if (measurement.force_noise_given() || !may_be_filtered(measurement)) return {};
  const std::vector<Ratio> ratios = ratios_of(measurement, fit_effects(measurement, default_baseline(), {}));
  const double cut_Hz = falls_below_at_Hz(ratios, kHalf);
  const double fallen_Hz = falls_below_at_Hz(ratios, kFallen);
  if (cut_Hz == 0.0 || fallen_Hz <= cut_Hz) return {};
  // 1 / (1 + (f / cut)^n), forward and backward: n by where it has fallen.
  const double order = std::log(1.0 / kFallen - 1.0) / std::log(fallen_Hz / cut_Hz);
  const double flat_Hz = cut_Hz * std::pow(1.0 / (1.0 - kTaken) - 1.0, 1.0 / order);
  const double recorded_s = static_cast<double>(measurement.sample_count()) * measurement.tick_s();
  if (flat_Hz < bandwidth_of_enough_rows_Hz(recorded_s)) return {};
  return ForceFilter{cut_Hz, flat_Hz};
}

}  // namespace slipstack::workbench
