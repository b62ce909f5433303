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

/// Rows of a segment of the log: as short as a spectrum with three bands can be, so that some segments lie
/// between what happens at every reversal.
constexpr std::size_t kSegment = 32;
constexpr std::size_t kFewestSegments = 16;
/// Rank of the segments that tells the noise, as a fraction of them. What the model lacks adds to the noise
/// where it acts, and in a motion that repeats it acts in most segments.
constexpr double kRank = 0.25;  // -kMedianOfNormal of the normal distribution

/// Bands, as fractions of the bandwidth. Below the first, friction and motion dominate.
struct Band {
  double from;
  double to;
};
constexpr Band kBands[] = {{0.35, 0.55}, {0.55, 0.75}, {0.75, 0.95}};

/// Power of a segment in each of the bands.
using Powers = std::array<double, std::size(kBands)>;

/// Ratio of a quantile to the mean of the power of white noise in some neighbouring frequencies of one Hann
/// window: a chi-squared value. Frequencies next to each other have a squared correlation of 4/9, the next
/// 1/36 (Welch 1967); its quantile by Wilson and Hilferty (1931), `normal` that of the normal distribution.
double quantile_over_mean(std::size_t frequencies, double normal) {
  const auto count = static_cast<double>(frequencies);
  const double correlated = std::max(0.0, count - 1.0) * 4.0 / 9.0 + std::max(0.0, count - 2.0) / 36.0;
  const double degrees = 2.0 * count * count / (count + 2.0 * correlated);
  const double variance = 2.0 / (9.0 * degrees);
  const double root = 1.0 - variance + normal * std::sqrt(variance);
  return root * root * root;
}

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
    const Spectrum spectrum = power_spectrum({rows_N, kSegment}, row_rate_Hz, kSegment);
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

/// Mean power of white noise in one band, as the residual bounds it.
struct BandPower {
  double least = 0.0;  ///< besides the error by quantisation
  double most = 0.0;   ///< with it
};

/// Over the half of the segments with the weakest quantisation, if these are enough. In the others, the
/// subtraction of quantisation would give the uncertain difference of two large numbers. `frequencies`: how
/// many the band has, at least one.
BandPower power_where_least_quantised(const Segments& segments, std::size_t band, std::size_t frequencies) {
  const double at_rank = quantile_over_mean(frequencies, -kMedianOfNormal);
  const double at_median = quantile_over_mean(frequencies, 0.0);
  std::vector<double> quantised;
  quantised.reserve(segments.left.size());
  for (const Powers& power : segments.quantised) quantised.push_back(power[band]);
  const std::size_t last = std::max(kFewestSegments, (quantised.size() + 1) / 2) - 1;
  const double weakest = value_at_rank(std::move(quantised), last);
  std::vector<double> left;
  std::vector<double> unquantised;
  for (std::size_t segment = 0; segment < segments.left.size(); ++segment) {
    if (segments.quantised[segment][band] > weakest) continue;
    left.push_back(segments.left[segment][band] / at_median);
    unquantised.push_back(segments.left[segment][band] / at_rank - segments.quantised[segment][band]);
  }
  return {quantile(std::move(unquantised), kRank), median(std::move(left))};
}

/// Power of the three bands that noise causes: white force noise of density one, and the encoder's
/// quantisation through the mass.
struct BandNoise {
  Powers response{};
  Powers encoder{};
  std::array<std::size_t, std::size(kBands)> frequencies{};
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
      ++noise.frequencies[b];
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
    const BandPower power = power_where_least_quantised(segments, b, noise.frequencies[b]);
    least = std::min(least, std::max(0.0, (power.least - noise.encoder[b]) / noise.response[b]));
    most = std::max(most, (power.most - noise.encoder[b]) / noise.response[b]);
  }
  if (!std::isfinite(least)) return {};
  const double band_Hz = 0.5 * measurement.sample_rate_Hz();
  return {std::sqrt(least * band_Hz), std::sqrt(most * band_Hz)};
}

}  // namespace slipstack::workbench
