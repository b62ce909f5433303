// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/ringing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>

#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/ringing_band.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Least density of a peak over that beside it. Of 24 simulated axes the lobes that the motion itself has up
/// there, unseen by the encoder, rise to 5; decaying oscillations of 3 % damping rise to 20 and more.
constexpr double kLeastRise = 10.0;

/// A peak in a spectrum, over the median of the bins within a fifth of its frequency. A smooth motion has
/// wide lobes in its spectrum, which are as high there.
struct Peak {
  std::size_t first_bin = 0;  ///< of those that rise
  std::size_t end_bin = 0;
  std::size_t bin = 0;
  double beside = 0.0;  ///< density
  double rise = 0.0;    ///< density over that beside it
  double power = 0.0;   ///< beyond what is beside it
};

/// The peaks from `first_bin` on, that of most power first.
std::vector<Peak> peaks_of(const Spectrum& spectrum, std::size_t first_bin) {
  const double bin_Hz = spectrum.frequency_Hz[1];
  std::vector<Peak> peaks;
  const auto rises = [&](std::size_t bin, double beside) { return spectrum.density[bin] > 2.0 * beside; };
  for (std::size_t k = first_bin + 1; k + 1 < spectrum.density.size(); ++k) {
    if (spectrum.density[k] < spectrum.density[k - 1] || spectrum.density[k] < spectrum.density[k + 1])
      continue;
    Peak peak{k, k + 1, k, density_beside(spectrum, k, first_bin)};
    peak.rise = spectrum.density[k] / std::max(peak.beside, 1e-300);
    if (peak.rise < kLeastRise) continue;
    while (peak.first_bin > first_bin && rises(peak.first_bin - 1, peak.beside)) --peak.first_bin;
    while (peak.end_bin < spectrum.density.size() && rises(peak.end_bin, peak.beside)) ++peak.end_bin;
    for (std::size_t i = peak.first_bin; i < peak.end_bin; ++i)
      peak.power += (spectrum.density[i] - peak.beside) * bin_Hz;
    peaks.push_back(peak);
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.power > b.power; });
  return peaks;
}

/// The probability that chance lets a mean of `count` independent exponential powers rise so far (bound of
/// Chernoff 1952).
double chance_of(double rise, double count) {
  return std::exp(-count * (rise - 1.0 - std::log(rise)));
}

/// Whether the speeds at which a peak is there are further apart than its frequencies. Those of a force that
/// depends on the position are apart as the speeds are, so that it has a narrow peak at one speed only.
bool is_there_at_many_speeds(std::span<const double> residual_N, std::span<const double> velocity_mps,
                             double rate_Hz, const Spectrum& spectrum, const Peak& peak) {
  const double frequency_Hz = spectrum.frequency_Hz[peak.bin];
  const double half_width_Hz =
      0.5 * spectrum.frequency_Hz[1] * static_cast<double>(peak.end_bin - peak.first_bin);
  std::vector<std::complex<double>> sums(residual_N.size() + 1);
  for (std::size_t i = 0; i < residual_N.size(); ++i) {
    const double phase = 2.0 * std::numbers::pi * frequency_Hz / rate_Hz * static_cast<double>(i);
    sums[i + 1] = sums[i] + residual_N[i] * std::polar(1.0, phase);
  }
  // Over windows as long as the peak is narrow. Of white noise of density S the squared sum over w samples is
  // S rate w / 2.
  const auto window = static_cast<std::size_t>(std::max(1.0, 0.5 * rate_Hz / half_width_Hz));
  const double beside = 0.5 * peak.beside * rate_Hz * static_cast<double>(window);
  double sum = 0.0;
  double first = 0.0;
  double second = 0.0;
  for (std::size_t i = window; i < sums.size(); ++i) {
    const double power = std::norm(sums[i] - sums[i - window]);
    if (power < kLeastRise * beside) continue;
    const double speed = std::abs(velocity_mps[i - 1 - window / 2]);
    sum += power;
    first += power * speed;
    second += power * speed * speed;
  }
  if (!(sum > 0.0)) return false;
  const double mean = first / sum;
  return second / sum - mean * mean > squared(2.0 * half_width_Hz / frequency_Hz * mean);
}

/// Mass times the recorded acceleration, by differences, with the noise of the encoder.
std::vector<double> inertial_force_N(const Measurement& measurement, const LogPart& part, double mass_kg) {
  const double* const position_m = measurement.log().position_m.data() + part.first_sample;
  std::vector<double> inertial_N(part.sample_count, 0.0);
  for (std::size_t i = 1; i + 1 < part.sample_count; ++i) {
    inertial_N[i] = mass_kg * squared(measurement.sample_rate_Hz()) *
                    (position_m[i - 1] - 2.0 * position_m[i] + position_m[i + 1]);
  }
  return inertial_N;
}

/// Whether the recorded acceleration has a peak there too: it is the motion of the mass, which the smooth
/// motion of the model lacks at these frequencies.
bool is_motion(const Spectrum& of_mass, std::size_t first_bin, double segments, const Peak& peak) {
  const double beside = density_beside(of_mass, peak.bin, first_bin);
  const double rise = of_mass.density[peak.bin] / std::max(beside, 1e-300);
  return rise > 1.0 && !is_chance(chance_of(rise, segments), 1.0) &&
         of_mass.density[peak.bin] - beside > kMajority * (peak.rise - 1.0) * peak.beside;
}

/// Whether the force has most of the peak, and as a peak: not so what the encoder's steps make of the mass,
/// nor what is left of a motion that the model has up to a frequency.
bool is_in_force(const Spectrum& of_force, std::size_t first_bin, const Peak& peak) {
  const double own = of_force.density[peak.bin];
  return own >= kMajority * peak.rise * peak.beside &&
         own >= kLeastRise * density_beside(of_force, peak.bin, first_bin);
}

/// What rings in one part, and how much of it.
struct Ringing {
  double frequency_Hz = 0.0;
  double half_width_Hz = 0.0;
  double power_N2 = 0.0;
};

/// The strongest peak that is no motion, nor the encoder's, nor that of a position.
std::optional<Ringing> ringing_of(const Measurement& measurement, const LogPart& part, double mass_kg,
                                  std::span<const double> residual_N) {
  const double rate_Hz = measurement.sample_rate_Hz();
  const std::size_t segment = segment_above_rows(measurement, residual_N.size());
  const Spectrum spectrum = power_spectrum(residual_N, rate_Hz, segment);
  if (spectrum.density.empty()) return {};
  const double bin_Hz = spectrum.frequency_Hz[1];
  const auto of_part = [&](const std::vector<double>& signal) {
    return std::span(signal).subspan(part.first_sample, part.sample_count);
  };
  const double period_s = rows_of_period(measurement, part) / measurement.row_rate_Hz();
  if (period_s > 0.0 && period_s * bin_Hz < 1.0) return {};  // harmonics of the motion are apart
  const auto first_bin = static_cast<std::size_t>(std::ceil(measurement.bandwidth_Hz() / bin_Hz));
  const Spectrum of_force = power_spectrum(of_part(measurement.log().force_N), rate_Hz, segment);
  const Spectrum of_mass = power_spectrum(inertial_force_N(measurement, part, mass_kg), rate_Hz, segment);
  const double segments = static_cast<double>(residual_N.size()) / static_cast<double>(segment);
  for (const Peak& peak : peaks_of(spectrum, first_bin)) {
    if (is_chance(chance_of(peak.rise, segments), static_cast<double>(spectrum.density.size())) ||
        !is_in_force(of_force, first_bin, peak) || is_motion(of_mass, first_bin, segments, peak) ||
        !is_there_at_many_speeds(residual_N, of_part(measurement.velocity_mps()), rate_Hz, spectrum, peak)) {
      continue;
    }
    return Ringing{spectrum.frequency_Hz[peak.bin],
                   0.5 * bin_Hz * static_cast<double>(peak.end_bin - peak.first_bin), peak.power};
  }
  return {};
}

}  // namespace

std::optional<Structure> ringing_beyond_rows(const Measurement& measurement, const FittedModel& model) {
  const std::vector<double>& model_N = model.linearisation->sample_force_N();
  const double error_N = model.train_rmse_N;
  std::optional<Ringing> strongest;
  for (const LogPart& part : measurement.parts()) {
    std::vector<double> residual_N(part.sample_count);
    for (std::size_t i = 0; i < residual_N.size(); ++i)
      residual_N[i] = measurement.log().force_N[part.first_sample + i] - model_N[part.first_sample + i];
    const auto own = ringing_of(measurement, part, mass_kg(model.terms), residual_N);
    if (own && (!strongest || own->power_N2 > strongest->power_N2)) strongest = own;
  }
  if (!strongest) return {};
  return Structure{
      Coordinate::frequency, 1.0 - error_N / std::sqrt(error_N * error_N + strongest->power_N2),
      strongest->frequency_Hz,
      fmt::format("what is left rings at {}, {} rms (a mode of the structure, "
                  "or an oscillation of the controller); the errors, which are those below {}, do not "
                  "contain it",
                  quantity_with_interval(strongest->frequency_Hz, strongest->half_width_Hz, "Hz"),
                  quantity(std::sqrt(strongest->power_N2), "N"), quantity(measurement.bandwidth_Hz(), "Hz")),
      Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
