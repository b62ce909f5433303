// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/lines.h"

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

/// Samples of a spectrum: as many as the log has parts for, within these.
constexpr std::size_t kLongestSegment = 2048;
constexpr std::size_t kShortestSegment = 256;
/// A line stands this far above both its sides: medians of spectra of noise reach three at most.
constexpr double kStandsOut = 8.0;
/// So far in the measured force too, where it stands among what else the force does.
constexpr double kInForce = 4.0;
/// The log is heard in so many parts or more. A line is in all of them, ringing after moves is not.
constexpr std::size_t kParts = 8;
/// Power that the median part has, of which all but a quarter of the parts have this share.
constexpr double kSteady = 0.25;

std::string described(double frequency_Hz, double amplitude_N) {
  return fmt::format("what is left is a line in time at {}, amplitude {}, whatever the motion",
                     quantity(frequency_Hz, "Hz"), quantity(amplitude_N, "N"));
}

/// Bins beside a line that it does not reach, through a Hann window.
constexpr std::size_t kNear = 4;
constexpr std::size_t kFar = 6;

/// How far a bin stands above the louder of its two sides: beside the edge of a broad hump (the encoder's
/// steps, seen through the mass up to where the motion's filter ends) one side is as high as the peak.
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

/// Power of the three bins that a line spreads over, through a Hann window.
double power_at(const Spectrum& spectrum, std::size_t bin) {
  const double width_Hz = spectrum.frequency_Hz[1] - spectrum.frequency_Hz[0];
  return (spectrum.density[bin - 1] + spectrum.density[bin] + spectrum.density[bin + 1]) * width_Hz;
}

/// The longest segment of which a signal has enough; zero where it has not.
std::size_t segment_for(std::size_t samples) {
  std::size_t segment = kLongestSegment;
  while (segment * kParts > samples) segment /= 2;
  return segment < kShortestSegment ? 0 : segment;
}

/// Spectra of the parts of a signal, in the order of time; none of a short one.
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

/// At each frequency what the median part has. A few loud moves, or a controller that hunts for a while, have
/// all frequencies and would hide a line that is there all the time.
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

/// Whether nearly all parts have the line: a controller that hunts within an encoder's step makes one too,
/// but only while the axis rests.
bool steady(const std::vector<Spectrum>& parts, std::size_t bin) {
  std::vector<double> powers;
  powers.reserve(parts.size());
  for (const Spectrum& part : parts) powers.push_back(power_at(part, bin));
  std::sort(powers.begin(), powers.end());
  return powers[powers.size() / 4] >= kSteady * powers[powers.size() / 2];
}

/// Rows of a spectrum, at most.
constexpr std::size_t kLongestRowSegment = 1024;

double row_rate_Hz(const Measurement& measurement) {
  return measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
}

std::span<const double> rows_of(const Eigen::VectorXd& residual_N) {
  return {residual_N.data(), static_cast<std::size_t>(residual_N.size())};
}

Spectrum row_spectrum(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  // Of few rows a coarser one: a line's own frequency is looked for around its peak anyway.
  const std::size_t segment = std::bit_floor(static_cast<std::size_t>(residual_N.size()));
  return power_spectrum(rows_of(residual_N), row_rate_Hz(measurement), std::min(segment, kLongestRowSegment));
}

/// The strongest line at the rows between `around_Hz` - `width_Hz` and `around_Hz` + `width_Hz`.
Structure line_within(const Measurement& measurement, const Eigen::VectorXd& residual_N, double around_Hz,
                      double width_Hz) {
  const Eigen::VectorXd times = row_times(measurement);
  // The phase must hold over each part: steps of a third of a turn over its length around the peak.
  std::size_t longest = 0;
  for (const LogPart& part : measurement.parts()) longest = std::max(longest, part.sample_count);
  const double step_Hz = 0.3 / (static_cast<double>(longest) * measurement.tick_s());
  const auto columns_at = [&](double frequency_Hz) {
    const std::vector<LogPart>& parts = measurement.parts();
    Eigen::MatrixXd columns =
        Eigen::MatrixXd::Zero(residual_N.size(), 2 * static_cast<Eigen::Index>(parts.size()));
    const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * times.array();
    for (std::size_t p = 0; p < parts.size(); ++p) {  // each log has its own phase
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
  const HeldOut judged =
      held_out(columns_at(frequency_Hz), residual_N, alternating_blocks(residual_N.size()));
  return {Coordinate::frequency, judged.error_reduction, frequency_Hz,
          described(frequency_Hz, judged.explained.cwiseAbs().maxCoeff()), judged.explained};
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
  // Beside what moves leave, which is louder at low frequencies, one that is there all the time stands out.
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

Structure line_near(const Measurement& measurement, const Eigen::VectorXd& residual_N, double frequency_Hz) {
  const Spectrum spectrum = row_spectrum(measurement, residual_N);
  if (spectrum.density.size() < 2)
    return {Coordinate::frequency, 0.0, frequency_Hz, "", Eigen::VectorXd::Zero(residual_N.size())};
  return line_within(measurement, residual_N, frequency_Hz, spectrum.frequency_Hz[1]);
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
  // At one slow speed driven again and again the encoder's steps come at one frequency, and through mass
  // times acceleration that is a line: of the encoder, and not in the force.
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
  return Structure{Coordinate::frequency, reduction, frequency_Hz,
                   described(frequency_Hz, std::sqrt(2.0 * power)),
                   Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
