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

/// Rows of a piece, and of the segments whose spectra are averaged within it.
constexpr std::size_t kPiece = 64;
constexpr std::size_t kSegment = 32;
constexpr std::size_t kFewestPieces = 8;

/// Bands within the bandwidth. Below the first, friction and motion are loud.
struct Band {
  double from;
  double to;
};
constexpr Band kBands[] = {{0.35, 0.55}, {0.55, 0.75}, {0.75, 0.95}};

/// Power of a piece in each of them.
using Powers = std::array<double, std::size(kBands)>;

/// The median of a piece's power in a band over its mean, for white noise (drawn: some eight degrees of
/// freedom).
constexpr double kMedianOverMean = 0.91;

/// Squared magnitude of the rows' filter and of the inverse of a low pass of `filter_s`, with what folds
/// because the rows are as far apart as they are.
double power_response(const Measurement& measurement, double frequency_Hz, double row_rate_Hz,
                      double filter_s) {
  const std::vector<double>& taps = measurement.filter().taps();
  const std::size_t half = taps.size() / 2;
  double power = 0.0;
  for (int fold = -2; fold <= 2; ++fold) {
    const double turn = kTwoPi * (frequency_Hz + fold * row_rate_Hz) * measurement.tick_s();
    double response = 0.0;
    for (std::size_t k = 0; k < taps.size(); ++k) {
      response += taps[k] * std::cos(turn * (static_cast<double>(k) - static_cast<double>(half)));
    }
    power += response * response * (1.0 + std::pow(turn * measurement.sample_rate_Hz() * filter_s, 2));
  }
  return power;
}

/// What pieces of a log have in the bands.
struct Pieces {
  std::vector<Powers> left;       ///< of what the model leaves
  std::vector<Powers> quantised;  ///< mean of what other readings differ by
  std::vector<double> frequency_Hz;
};

Pieces chunks_of(const Measurement& measurement, const LogPart& part, double row_rate_Hz,
                 const Eigen::VectorXd& residual_N, const std::vector<Eigen::VectorXd>& realisations_N) {
  Pieces pieces;
  const auto powers_of = [&](const double* rows_N) {
    const Spectrum spectrum = power_spectrum({rows_N, kPiece}, row_rate_Hz, kSegment);
    pieces.frequency_Hz = spectrum.frequency_Hz;
    Powers power{};
    for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
      const double at = spectrum.frequency_Hz[k] / measurement.bandwidth_Hz();
      for (std::size_t b = 0; b < power.size(); ++b) {
        if (at >= kBands[b].from && at < kBands[b].to) power[b] += spectrum.density[k];
      }
    }
    return power;
  };
  for (std::size_t piece = 0; piece < part.row_count / kPiece; ++piece) {
    const std::size_t first = part.first_row + piece * kPiece;
    const auto rows = static_cast<Eigen::Index>(first);
    if (measurement.row_usable().segment(rows, kPiece).minCoeff() == 0.0) continue;
    pieces.left.push_back(powers_of(residual_N.data() + first));
    pieces.quantised.emplace_back();
    for (const Eigen::VectorXd& reading_N : realisations_N) {
      const Powers power = powers_of(reading_N.data() + first);
      for (std::size_t b = 0; b < power.size(); ++b) {
        pieces.quantised.back()[b] += power[b] / static_cast<double>(realisations_N.size());
      }
    }
  }
  return pieces;
}

/// Median powers in one band.
struct Heard {
  double left = 0.0;
  double unquantised = 0.0;  ///< without what quantisation does
};

/// Where quantisation is loud, what is left without it is the difference of two large numbers, anything: the
/// half of the pieces where it does least tells, if these are enough.
Heard noise_where_least_quantised(const Pieces& pieces, std::size_t band) {
  std::vector<double> quantised;
  quantised.reserve(pieces.left.size());
  for (const Powers& power : pieces.quantised) quantised.push_back(power[band]);
  const std::size_t last = std::max(kFewestPieces, (quantised.size() + 1) / 2) - 1;
  const double most = value_at_rank(std::move(quantised), last);
  std::vector<double> left;
  std::vector<double> unquantised;
  for (std::size_t piece = 0; piece < pieces.left.size(); ++piece) {
    if (pieces.quantised[piece][band] > most) continue;
    left.push_back(pieces.left[piece][band]);
    unquantised.push_back(pieces.left[piece][band] - pieces.quantised[piece][band]);
  }
  return {median(std::move(left)), median(std::move(unquantised))};
}

}  // namespace

double NoiseEstimate::bounded(double sensor_N) const {
  return std::clamp(sensor_N, least_N, std::max(least_N, most_N));
}

NoiseEstimate residual_noise(const Measurement& measurement, const LogPart& part,
                             const Eigen::VectorXd& residual_N,
                             const std::vector<Eigen::VectorXd>& realisations_N, double mass_kg,
                             const MeasurementDynamics& lag) {
  const double row_rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
  const Pieces pieces = chunks_of(measurement, part, row_rate_Hz, residual_N, realisations_N);
  if (pieces.left.size() < kFewestPieces) return {};
  const double quantisation = mass_kg * measurement.position_noise_m_per_root_Hz(part);
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (std::size_t b = 0; b < std::size(kBands); ++b) {
    double response = 0.0;  // of white force noise of density one
    double encoder = 0.0;
    for (const double f : pieces.frequency_Hz) {
      const double at = f / measurement.bandwidth_Hz();
      if (at < kBands[b].from || at >= kBands[b].to) continue;
      response += power_response(measurement, f, row_rate_Hz, lag.filter_s);
      const double own = power_response(measurement, f, row_rate_Hz, 0.0);
      encoder += own * std::pow(kTwoPi * f, 4) * quantisation * quantisation;
    }
    if (response <= 0.0) continue;
    const Heard heard = noise_where_least_quantised(pieces, b);
    least = std::min(least, std::max(0.0, (heard.unquantised / kMedianOverMean - encoder) / response));
    most = std::max(most, (heard.left / kMedianOverMean - encoder) / response);
  }
  if (!std::isfinite(least)) return {};
  const double band_Hz = 0.5 * measurement.sample_rate_Hz();
  return {std::sqrt(least * band_Hz), std::sqrt(most * band_Hz)};
}

}  // namespace slipstack::workbench
