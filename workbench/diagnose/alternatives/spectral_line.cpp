// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/spectral_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Limits of the length of a spectrum's segment, in samples; the log must have kParts such segments.
constexpr std::size_t kLongestSegment = 2048;
constexpr std::size_t kShortestSegment = 256;
/// A line exceeds the density on both its sides by this factor; in medians of spectra of noise the factor is
/// three at most.
constexpr double kStandsOut = 8.0;
/// The same factor for the measured force, in which the line is one part among others. Chosen.
constexpr double kInForce = 4.0;
/// The least number of parts into which the log is divided. A line is in all of them; ringing after moves is
/// not.
constexpr std::size_t kParts = 8;
/// Three quarters of the parts must have this share of the power of the median part. Chosen.
constexpr double kSteady = 0.25;

/// Two values, each with half the width of its interval.
struct Line {
  double frequency_Hz = 0.0;
  double frequency_half_width_Hz = 0.0;
  double amplitude_N = 0.0;
  double amplitude_half_width_N = 0.0;
};

std::string described(const Line& line) {
  return fmt::format("what is left is a line in time at {}, amplitude {}, whatever the motion",
                     quantity_with_interval(line.frequency_Hz, line.frequency_half_width_Hz, "Hz"),
                     quantity_with_interval(line.amplitude_N, line.amplitude_half_width_N, "N"));
}

/// Distances in bins at which a line no longer contributes, with a Hann window.
constexpr std::size_t kNear = 4;
constexpr std::size_t kFar = 6;

/// The ratio of a bin to the larger density on its two sides. At the edge of a broad hump (quantisation times
/// mass, up to the bandwidth of the motion's filter) one side is as high as the peak.
double prominence(const Spectrum& spectrum, std::size_t bin) {
  double left = 0.0;
  double right = 0.0;
  for (std::size_t away = kNear; away <= kFar; ++away) {
    left += spectrum.density[bin - away];
    right += spectrum.density[bin + away];
  }
  const double beside = std::max(left, right) / static_cast<double>(kFar - kNear + 1);
  return spectrum.density[bin] / std::max(beside, 1e-300);
}

/// Power of the three bins over which a Hann window spreads a line.
double power_at(const Spectrum& spectrum, std::size_t bin) {
  const double width_Hz = spectrum.frequency_Hz[1] - spectrum.frequency_Hz[0];
  return (spectrum.density[bin - 1] + spectrum.density[bin] + spectrum.density[bin + 1]) * width_Hz;
}

/// The longest segment that a signal has kParts of; zero where it is too short.
std::size_t segment_for(std::size_t samples) {
  std::size_t segment = kLongestSegment;
  while (segment * kParts > samples) segment /= 2;
  return segment < kShortestSegment ? 0 : segment;
}

/// Spectra of the parts of a signal in the order of time; none where it is too short.
std::vector<Spectrum> spectra_of_parts(std::span<const double> signal, double rate_Hz) {
  const std::size_t segment = segment_for(signal.size());
  if (segment == 0) return {};
  const std::size_t parts = signal.size() / segment;
  const std::size_t length = signal.size() / parts;
  std::vector<Spectrum> spectra;
  spectra.reserve(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    spectra.push_back(power_spectrum(signal.subspan(part * length, length), rate_Hz, segment));
  }
  return spectra;
}

/// The median over the parts at each frequency. A few moves of large residual, or a controller that hunts for
/// a while, contain all frequencies and would hide a line that is present all the time.
Spectrum median_spectrum(const std::vector<Spectrum>& parts) {
  if (parts.empty()) return {};
  Spectrum spectrum = parts.front();
  std::vector<double> densities(parts.size());
  for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
    for (std::size_t p = 0; p < parts.size(); ++p) densities[p] = parts[p].density[k];
    spectrum.density[k] = median(densities);
  }
  return spectrum;
}

/// Whether nearly all parts have the line: a controller that hunts within an encoder step causes one too, but
/// only while the axis stands.
bool steady(const std::vector<Spectrum>& parts, std::size_t bin) {
  std::vector<double> powers;
  powers.reserve(parts.size());
  for (const Spectrum& part : parts) powers.push_back(power_at(part, bin));
  std::sort(powers.begin(), powers.end());
  return powers[powers.size() / 4] >= kSteady * powers[powers.size() / 2];
}

/// Standard error of the median over the parts of their power at a line: sqrt(pi / 2) of that of the mean
/// (Kendall and Stuart, The Advanced Theory of Statistics, volume 1, 10.11).
double error_of_median(const std::vector<Spectrum>& parts, std::size_t bin) {
  double sum = 0.0;
  double squares = 0.0;
  for (const Spectrum& part : parts) {
    const double power = power_at(part, bin);
    sum += power;
    squares += power * power;
  }
  const auto count = static_cast<double>(parts.size());
  const double variance = std::max(0.0, squares - sum * sum / count) / std::max(1.0, count - 1.0);
  return std::sqrt(0.5 * std::numbers::pi * variance / count);
}

/// The longest segment of a spectrum of the rows.
constexpr std::size_t kLongestRowSegment = 1024;

double row_rate_Hz(const Measurement& measurement) {
  return measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
}

std::span<const double> rows_of(const Eigen::VectorXd& residual_N) {
  return {residual_N.data(), static_cast<std::size_t>(residual_N.size())};
}

Spectrum row_spectrum(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  // With few rows the resolution is coarser; the frequency of the line is refined around the peak anyway.
  const std::size_t segment = std::bit_floor(static_cast<std::size_t>(residual_N.size()));
  return power_spectrum(rows_of(residual_N), row_rate_Hz(measurement), std::min(segment, kLongestRowSegment));
}

/// The line of the largest amplitude among the parts, from its cosine and sine columns and their gains; two
/// standard errors to either side, frequency and gains jointly.
Line with_intervals(const Eigen::MatrixXd& columns, const Eigen::VectorXd& times,
                    const Eigen::VectorXd& residual_N, double frequency_Hz, const Eigen::VectorXd& gains) {
  Eigen::MatrixXd all(columns.rows(), columns.cols() + 1);
  all.leftCols(columns.cols()) = columns;
  auto slope = all.col(columns.cols());  // derivative by the frequency
  slope.setZero();
  Line line{frequency_Hz};
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(all.cols(), 2);
  for (Eigen::Index i = 0; i < gains.size(); i += 2) {
    slope += 2.0 * std::numbers::pi *
             times.cwiseProduct(gains(i + 1) * columns.col(i) - gains(i) * columns.col(i + 1));
    const double amplitude_N = std::hypot(gains(i), gains(i + 1));
    if (amplitude_N <= line.amplitude_N) continue;
    line.amplitude_N = amplitude_N;
    sums.col(0).setZero();
    sums.col(0).segment(i, 2) = gains.segment(i, 2) / amplitude_N;
  }
  sums(columns.cols(), 1) = 1.0;
  const Eigen::VectorXd errors = errors_of_sums(all, residual_N, alternating_blocks(residual_N.size()), sums);
  line.amplitude_half_width_N = 2.0 * errors(0);
  line.frequency_half_width_Hz = 2.0 * errors(1);
  return line;
}

/// The strongest line at the rows between `around_Hz` - `width_Hz` and `around_Hz` + `width_Hz`.
Structure line_within(const Measurement& measurement, const Eigen::VectorXd& residual_N, double around_Hz,
                      double width_Hz) {
  const Eigen::VectorXd times = row_times(measurement);
  // The phase must hold over each part: the frequency steps by 0.3 of a period over the longest part.
  std::size_t longest = 0;
  for (const LogPart& part : measurement.parts()) longest = std::max(longest, part.sample_count);
  const double step_Hz = 0.3 / (static_cast<double>(longest) * measurement.tick_s());
  const auto columns_at = [&](double frequency_Hz) {
    const std::vector<LogPart>& parts = measurement.parts();
    Eigen::MatrixXd columns =
        Eigen::MatrixXd::Zero(residual_N.size(), 2 * static_cast<Eigen::Index>(parts.size()));
    const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * times.array();
    for (std::size_t p = 0; p < parts.size(); ++p) {  // the phase differs from log to log
      const auto first = static_cast<Eigen::Index>(parts[p].first_row);
      const auto count = static_cast<Eigen::Index>(parts[p].row_count);
      const auto column = 2 * static_cast<Eigen::Index>(p);
      columns.col(column).segment(first, count) = phase.segment(first, count).cos();
      columns.col(column + 1).segment(first, count) = phase.segment(first, count).sin();
    }
    return columns;
  };
  double strongest = 0.0;
  double frequency_Hz = around_Hz;
  for (double f = around_Hz - width_Hz; f <= around_Hz + width_Hz; f += step_Hz) {
    const double power = (columns_at(f).transpose() * residual_N).squaredNorm();
    if (power > strongest) {
      strongest = power;
      frequency_Hz = f;
    }
  }
  const Eigen::MatrixXd columns = columns_at(frequency_Hz);
  const HeldOut judged = held_out(columns, residual_N, alternating_blocks(residual_N.size()));
  const Line line = with_intervals(columns, times, residual_N, frequency_Hz, judged.value);
  return {Coordinate::frequency, judged.error_reduction, frequency_Hz, described(line), judged.explained};
}

}  // namespace

Structure line_at_rows(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const Spectrum spectrum = row_spectrum(measurement, residual_N);
  if (spectrum.density.empty())
    return {Coordinate::frequency, 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size())};
  std::size_t peak = 2;
  for (std::size_t k = 2; k < spectrum.density.size(); ++k) {
    if (spectrum.density[k] > spectrum.density[peak]) peak = k;
  }
  Structure strongest =
      line_within(measurement, residual_N, spectrum.frequency_Hz[peak], spectrum.frequency_Hz[1]);
  // The residual of moves is larger at low frequencies; a line that is present all the time exceeds the
  // median of the parts.
  const Spectrum usual = median_spectrum(spectra_of_parts(rows_of(residual_N), row_rate_Hz(measurement)));
  std::size_t sharpest = 0;
  double most = kStandsOut;
  for (std::size_t k = kFar; k + kFar < usual.density.size(); ++k) {
    if (prominence(usual, k) < most) continue;
    most = prominence(usual, k);
    sharpest = k;
  }
  if (sharpest == 0) return strongest;
  Structure steadiest =
      line_within(measurement, residual_N, usual.frequency_Hz[sharpest], usual.frequency_Hz[1]);
  return steadiest.error_reduction > strongest.error_reduction ? steadiest : strongest;
}

std::optional<Structure> line_beyond_rows(const Measurement& measurement, const std::vector<double>& model_N,
                                          double error_N) {
  std::vector<double> residual_N = measurement.log().force_N;
  for (std::size_t i = 0; i < residual_N.size(); ++i) residual_N[i] -= model_N[i];
  const double rate_Hz = measurement.sample_rate_Hz();
  const std::vector<Spectrum> parts = spectra_of_parts(residual_N, rate_Hz);
  const Spectrum spectrum = median_spectrum(parts);
  if (spectrum.density.size() < 4) return {};
  const double width_Hz = spectrum.frequency_Hz[1] - spectrum.frequency_Hz[0];
  const auto first = static_cast<std::size_t>(measurement.bandwidth_Hz() / width_Hz) + 2;
  // At a constant slow speed encoder steps come at one frequency, and mass times acceleration has a line
  // there that the measured force does not have.
  const Spectrum force = median_spectrum(spectra_of_parts(measurement.log().force_N, rate_Hz));
  std::size_t peak = 0;
  double most = kStandsOut;
  for (std::size_t k = std::max(first, kFar); k + kFar < spectrum.density.size(); ++k) {
    const double stands_out = std::min(prominence(spectrum, k), kStandsOut / kInForce * prominence(force, k));
    if (stands_out < most) continue;
    most = stands_out;
    peak = k;
  }
  if (peak == 0 || !steady(parts, peak)) return {};
  const double usual = spectrum.density[peak] / prominence(spectrum, peak);
  const double power = std::max(0.0, power_at(spectrum, peak) - 3.0 * usual * width_Hz);
  const double reduction = 1.0 - error_N / std::sqrt(error_N * error_N + power);
  const double frequency_Hz = spectrum.frequency_Hz[peak];
  const double amplitude_N = std::sqrt(2.0 * power);
  // The amplitude is to its power as its error to that of the power, halved: the frequency is known to a bin.
  const double amplitude_error_N = amplitude_N * 0.5 * error_of_median(parts, peak) / std::max(power, 1e-300);
  return Structure{Coordinate::frequency, reduction, frequency_Hz,
                   described({frequency_Hz, width_Hz, amplitude_N, 2.0 * amplitude_error_N}),
                   Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
