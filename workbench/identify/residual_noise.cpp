// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/residual_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "workbench/identify/spectrum.h"
#include "workbench/log/median.h"

namespace slipstack::workbench {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Rows of a piece, and of the segments whose spectra are averaged within it.
constexpr std::size_t kPiece = 128;
constexpr std::size_t kSegment = 64;
constexpr std::size_t kFewestPieces = 8;

/// Bands within the bandwidth. Below the first, friction and motion are loud.
struct Band {
  double from;
  double to;
};
constexpr Band kBands[] = {{0.35, 0.55}, {0.55, 0.75}, {0.75, 0.95}};

/// The median of a piece's power in a band over its mean, for white noise (drawn: some twelve degrees of
/// freedom).
constexpr double kMedianOverMean = 0.95;

/// Squared magnitude of the rows' filter and of the inverse of a low pass of `filter_s`, with what folds
/// because the rows are as far apart as they are.
double power_response(const Measurement& measurement, double frequency_Hz, double row_rate_Hz,
                      double filter_s) {
  const std::vector<double>& taps = measurement.filter().taps();
  const std::size_t half = taps.size() / 2;
  double power = 0.0;
  for (int fold = -2; fold <= 2; ++fold) {
    const double turn = kTurn * (frequency_Hz + fold * row_rate_Hz) * measurement.tick_s();
    double response = 0.0;
    for (std::size_t k = 0; k < taps.size(); ++k) {
      response += taps[k] * std::cos(turn * (static_cast<double>(k) - static_cast<double>(half)));
    }
    power += response * response * (1.0 + std::pow(turn * measurement.sample_rate_Hz() * filter_s, 2));
  }
  return power;
}

}  // namespace

double residual_noise_N(const Measurement& measurement, const LogPart& part,
                        const Eigen::VectorXd& residual_N, const std::vector<Eigen::VectorXd>& readings_N,
                        double mass_kg, const ForceLag& lag) {
  const std::size_t pieces = part.row_count / kPiece;
  if (pieces < kFewestPieces) return 0.0;
  const double row_rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
  std::vector<std::vector<double>> power(std::size(kBands));
  std::vector<double> frequency_Hz;
  const auto add_bands = [&](const double* rows_N, double sign, bool another) {
    const Spectrum spectrum = power_spectrum({rows_N, kPiece}, row_rate_Hz, kSegment);
    frequency_Hz = spectrum.frequency_Hz;
    for (std::size_t b = 0; b < power.size(); ++b) {
      if (another) power[b].push_back(0.0);
      for (std::size_t k = 0; k < frequency_Hz.size(); ++k) {
        const double at = frequency_Hz[k] / measurement.bandwidth_Hz();
        if (at >= kBands[b].from && at < kBands[b].to) power[b].back() += sign * spectrum.density[k];
      }
    }
  };
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const std::size_t first = part.first_row + piece * kPiece;
    const auto rows = static_cast<Eigen::Index>(first);
    if (measurement.row_usable().segment(rows, kPiece).minCoeff() == 0.0) continue;
    add_bands(residual_N.data() + first, 1.0, true);
    for (const Eigen::VectorXd& reading_N : readings_N) {
      add_bands(reading_N.data() + first, -1.0 / static_cast<double>(readings_N.size()), false);
    }
  }
  if (power[0].size() < kFewestPieces) return 0.0;
  const double quantisation = mass_kg * measurement.position_noise_m_per_root_Hz(part);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < power.size(); ++b) {
    double response = 0.0;  // of white force noise of density one
    double encoder = 0.0;
    for (const double f : frequency_Hz) {
      const double at = f / measurement.bandwidth_Hz();
      if (at < kBands[b].from || at >= kBands[b].to) continue;
      response += power_response(measurement, f, row_rate_Hz, lag.filter_s);
      const double own = power_response(measurement, f, row_rate_Hz, 0.0);
      encoder += own * std::pow(kTurn * f, 4) * quantisation * quantisation;
    }
    if (response <= 0.0) continue;
    const double density = (median(std::move(power[b])) / kMedianOverMean - encoder) / response;
    least = std::min(least, std::max(0.0, density));
  }
  if (!std::isfinite(least)) return 0.0;
  return std::sqrt(least * 0.5 * measurement.sample_rate_Hz());
}

}  // namespace slipstack::workbench
