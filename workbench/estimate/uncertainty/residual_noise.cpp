// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/residual_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Rows of a segment of the log, and of the windows whose spectra are averaged within it.
constexpr std::size_t kSegment = 64;
constexpr std::size_t kSpectrumWindow = 32;
constexpr std::size_t kFewestSegments = 8;

/// Bands, as fractions of the bandwidth. Below the first, friction and motion dominate.
struct Band {
  double from;
  double to;
};
constexpr Band kBands[] = {{0.35, 0.55}, {0.55, 0.75}, {0.75, 0.95}};

/// Power of a segment in each of the bands.
using Powers = std::array<double, std::size(kBands)>;

/// Ratio of the median to the mean of a segment's power in a band, for white noise: some eight degrees of
/// freedom. Determined by random draws.
constexpr double kMedianOverMean = 0.91;

/// Squared magnitude of the rows' filter, including the aliases by the spacing of the rows.
double power_response(const Measurement& measurement, double frequency_Hz, double row_rate_Hz) {
  const std::vector<double>& taps = measurement.filter().taps();
  const std::size_t half = taps.size() / 2;
  double power = 0.0;
  for (int fold = -2; fold <= 2; ++fold) {
    const double angle = kTwoPi * (frequency_Hz + fold * row_rate_Hz) * measurement.tick_s();
    double response = 0.0;
    for (std::size_t k = 0; k < taps.size(); ++k) {
      response += taps[k] * std::cos(angle * (static_cast<double>(k) - static_cast<double>(half)));
    }
    power += response * response;
  }
  return power;
}

/// Powers of the segments of a log.
struct Segments {
  std::vector<Powers> left;       ///< of the residual
  std::vector<Powers> quantised;  ///< of the error by quantisation, the mean over its realisations
  std::vector<double> frequency_Hz;
};

Segments segments_of(const Measurement& measurement, const LogPart& part, double row_rate_Hz,
                     const Eigen::VectorXd& residual_N, const std::vector<Eigen::VectorXd>& realisations_N) {
  Segments segments;
  const auto powers_of = [&](const double* rows_N) {
    const Spectrum spectrum = power_spectrum({rows_N, kSegment}, row_rate_Hz, kSpectrumWindow);
    segments.frequency_Hz = spectrum.frequency_Hz;
    Powers power{};
    for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
      const double at = spectrum.frequency_Hz[k] / measurement.bandwidth_Hz();
      for (std::size_t b = 0; b < power.size(); ++b) {
        if (at >= kBands[b].from && at < kBands[b].to) power[b] += spectrum.density[k];
      }
    }
    return power;
  };
  for (std::size_t segment = 0; segment < part.row_count / kSegment; ++segment) {
    const std::size_t first = part.first_row + segment * kSegment;
    const auto rows = static_cast<Eigen::Index>(first);
    if (measurement.row_usable().segment(rows, kSegment).minCoeff() == 0.0) continue;
    segments.left.push_back(powers_of(residual_N.data() + first));
    segments.quantised.emplace_back();
    for (const Eigen::VectorXd& realisation_N : realisations_N) {
      const Powers power = powers_of(realisation_N.data() + first);
      for (std::size_t b = 0; b < power.size(); ++b) {
        segments.quantised.back()[b] += power[b] / static_cast<double>(realisations_N.size());
      }
    }
  }
  return segments;
}

/// Median powers of the residual in one band.
struct BandPower {
  double left = 0.0;
  double unquantised = 0.0;  ///< after subtraction of the error by quantisation
};

/// Median powers over the half of the segments with the weakest quantisation, if these are enough. In the
/// others, the subtraction of quantisation would give the uncertain difference of two large numbers.
BandPower power_where_least_quantised(const Segments& segments, std::size_t band) {
  std::vector<double> quantised;
  quantised.reserve(segments.left.size());
  for (const Powers& power : segments.quantised) quantised.push_back(power[band]);
  const std::size_t last = std::max(kFewestSegments, (quantised.size() + 1) / 2) - 1;
  const double most = value_at_rank(std::move(quantised), last);
  std::vector<double> left;
  std::vector<double> unquantised;
  for (std::size_t segment = 0; segment < segments.left.size(); ++segment) {
    if (segments.quantised[segment][band] > most) continue;
    left.push_back(segments.left[segment][band]);
    unquantised.push_back(segments.left[segment][band] - segments.quantised[segment][band]);
  }
  return {median(std::move(left)), median(std::move(unquantised))};
}

/// Power of the three bands that noise causes: white force noise of density one, and the encoder's
/// quantisation through the mass.
struct BandNoise {
  Powers response{};
  Powers encoder{};
};

BandNoise band_noise(const Measurement& measurement, const LogPart& part, double row_rate_Hz,
                     const std::vector<double>& frequency_Hz, double mass_kg) {
  const double quantisation = mass_kg * measurement.position_noise_m_per_root_Hz(part);
  BandNoise noise;
  for (const double f : frequency_Hz) {
    const double at = f / measurement.bandwidth_Hz();
    for (std::size_t b = 0; b < std::size(kBands); ++b) {
      if (at < kBands[b].from || at >= kBands[b].to) continue;
      const double own = power_response(measurement, f, row_rate_Hz);
      noise.response[b] += own;
      noise.encoder[b] += own * std::pow(kTwoPi * f, 4) * quantisation * quantisation;
    }
  }
  return noise;
}

}  // namespace

double NoiseBounds::bounded(double sensor_N) const {
  return std::clamp(sensor_N, least_N, std::max(least_N, most_N));
}

NoiseBounds residual_noise(const Measurement& measurement, const LogPart& part,
                           const Eigen::VectorXd& residual_N,
                           const std::vector<Eigen::VectorXd>& realisations_N, double mass_kg) {
  const double row_rate_Hz = measurement.row_rate_Hz();
  const Segments segments = segments_of(measurement, part, row_rate_Hz, residual_N, realisations_N);
  if (segments.left.size() < kFewestSegments) return {};
  const BandNoise noise = band_noise(measurement, part, row_rate_Hz, segments.frequency_Hz, mass_kg);
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (std::size_t b = 0; b < std::size(kBands); ++b) {
    if (noise.response[b] <= 0.0) continue;
    const BandPower power = power_where_least_quantised(segments, b);
    least = std::min(
        least, std::max(0.0, (power.unquantised / kMedianOverMean - noise.encoder[b]) / noise.response[b]));
    most = std::max(most, (power.left / kMedianOverMean - noise.encoder[b]) / noise.response[b]);
  }
  if (!std::isfinite(least)) return {};
  const double band_Hz = 0.5 * measurement.sample_rate_Hz();
  return {std::sqrt(least * band_Hz), std::sqrt(most * band_Hz)};
}

}  // namespace slipstack::workbench
