// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/residual_dynamics.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "workbench/report/json_values.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestSegment = 1024;  // rows; as in the spectrum of the residual
constexpr std::size_t kShortestSegment = 64;
constexpr std::size_t kFewestSegments =
    15;  // half-overlapping: chance alone makes a coherence of 0.2; chosen
constexpr double kLongestLag_s = 1.0;
constexpr std::size_t kMostLags = 400;
constexpr double kChance = 0.05;
constexpr double kMostDeviation = 0.2;  // of a response that is drawn; chosen

/// Usable rows without a gap between them.
std::vector<RowRange> runs_of(const Measurement& measurement) {
  std::vector<RowRange> runs;
  for (const LogPart& part : measurement.parts()) {
    const auto end = static_cast<Eigen::Index>(part.first_row + part.row_count);
    bool open = false;
    for (auto row = static_cast<Eigen::Index>(part.first_row); row < end; ++row) {
      const bool usable = measurement.row_usable()(row) != 0.0;
      if (usable && !open) runs.push_back({row, 0});
      if (usable) ++runs.back().count;
      open = usable;
    }
  }
  return runs;
}

/// Half-overlapping segments of this length that the runs have room for.
std::size_t segments_in(const std::vector<RowRange>& runs, std::size_t segment) {
  std::size_t count = 0;
  for (const RowRange& run : runs) {
    const auto rows = static_cast<std::size_t>(run.count);
    if (rows >= segment) count += (rows - segment) / (segment / 2) + 1;
  }
  return count;
}

CrossSpectrum cross_spectrum(const Measurement& measurement, const Eigen::VectorXd& input,
                             const Eigen::VectorXd& output) {
  const std::vector<RowRange> runs = runs_of(measurement);
  std::size_t segment = kLongestSegment;
  while (segment > kShortestSegment && segments_in(runs, segment) < kFewestSegments) segment /= 2;
  CrossSpectrum spectrum(measurement.row_rate_Hz(), segment);
  if (segments_in(runs, segment) < kFewestSegments) return spectrum;
  for (const RowRange& run : runs) {
    const auto count = static_cast<std::size_t>(run.count);
    spectrum.add({input.data() + run.first, count}, {output.data() + run.first, count});
  }
  return spectrum;
}

/// Bins that are judged: those of the frequencies above zero, up to the bandwidth.
template <class Visit>
void each_bin(const CrossSpectrum& spectrum, double bandwidth_Hz, Visit&& visit) {
  if (spectrum.segments() == 0) return;
  for (std::size_t bin = 1; bin < spectrum.bins() && spectrum.frequency_Hz(bin) <= bandwidth_Hz; ++bin) {
    visit(bin);
  }
}

/// Correlation of white noise with itself after the filter, `lag` rows later.
std::vector<double> filter_correlation(const Measurement& measurement, std::size_t lags) {
  const std::vector<double>& taps = measurement.filter().taps();
  std::vector<double> correlation;
  for (std::size_t lag = 0; lag < lags; ++lag) {
    const std::size_t apart = lag * measurement.row_stride();
    double sum = 0.0;
    for (std::size_t i = 0; i + apart < taps.size(); ++i) sum += taps[i] * taps[i + apart];
    correlation.push_back(sum);
  }
  const double whole = correlation.front();
  for (double& value : correlation) value /= whole;
  return correlation;
}

Eigen::VectorXd acceleration_at_rows(const Measurement& measurement) {
  return measurement.filtered(measurement.acceleration_mps2());
}

MotionCoherence coherence_with(const Measurement& measurement, const Eigen::VectorXd& acceleration_mps2,
                               const Eigen::VectorXd& residual_N) {
  const CrossSpectrum spectrum = cross_spectrum(measurement, acceleration_mps2, residual_N);
  MotionCoherence found;
  found.chance = spectrum.chance_coherence(kChance);
  each_bin(spectrum, measurement.bandwidth_Hz(), [&](std::size_t bin) {
    found.frequency_Hz.push_back(spectrum.frequency_Hz(bin));
    found.coherence.push_back(spectrum.coherence(bin));
  });
  return found;
}

AxisResponse response_of(const Measurement& measurement, const Eigen::VectorXd& acceleration_mps2,
                         const Eigen::VectorXd& force_N) {
  const CrossSpectrum spectrum = cross_spectrum(measurement, force_N, acceleration_mps2);
  AxisResponse found;
  each_bin(spectrum, measurement.bandwidth_Hz(), [&](std::size_t bin) {
    found.frequency_Hz.push_back(spectrum.frequency_Hz(bin));
    found.per_kg.push_back(spectrum.response(bin));
    found.deviation.push_back(spectrum.response_deviation(bin));
  });
  return found;
}

json response_json(const AxisResponse& response, const AxisResponse& measured) {
  json gain = json::array();
  json phase = json::array();
  for (std::size_t i = 0; i < response.per_kg.size(); ++i) {
    const bool certain = measured.deviation[i] <= kMostDeviation && response.deviation[i] <= kMostDeviation;
    gain.push_back(certain ? number_json(std::abs(response.per_kg[i])) : json());
    phase.push_back(certain ? number_json(std::arg(response.per_kg[i])) : json());
  }
  return {{"gain", gain}, {"phase_rad", phase}};
}

}  // namespace

MotionCoherence motion_coherence(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  return coherence_with(measurement, acceleration_at_rows(measurement), residual_N);
}

AxisResponse axis_response(const Measurement& measurement, const Eigen::VectorXd& force_N) {
  return response_of(measurement, acceleration_at_rows(measurement), force_N);
}

Autocorrelation autocorrelation(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const double rate_Hz = measurement.row_rate_Hz();
  const auto lags = std::min(kMostLags, static_cast<std::size_t>(kLongestLag_s * rate_Hz)) + 1;
  std::vector<double> sum(lags, 0.0);
  for (const RowRange& run : runs_of(measurement)) {
    for (std::size_t lag = 0; lag < lags && static_cast<Eigen::Index>(lag) < run.count; ++lag) {
      const auto count = run.count - static_cast<Eigen::Index>(lag);
      sum[lag] += residual_N.segment(run.first, count)
                      .dot(residual_N.segment(run.first + static_cast<Eigen::Index>(lag), count));
    }
  }
  Autocorrelation found;
  if (!(sum[0] > 0.0)) return found;
  found.white = filter_correlation(measurement, lags);
  for (std::size_t lag = 0; lag < lags; ++lag) {
    found.lag_s.push_back(static_cast<double>(lag) / rate_Hz);
    found.correlation.push_back(sum[lag] / sum[0]);
  }
  return found;
}

void add_residual_dynamics(json& data, const Measurement& measurement, const ForceRows& before,
                           const ForceRows* after) {
  const Eigen::VectorXd acceleration_mps2 = acceleration_at_rows(measurement);
  const MotionCoherence coherence = coherence_with(measurement, acceleration_mps2, before.residual_N());
  if (!coherence.frequency_Hz.empty()) {
    data["coherence"] = {{"frequency_Hz", coherence.frequency_Hz},
                         {"residual", coherence.coherence},
                         {"chance", coherence.chance}};
    if (after != nullptr)
      data["coherence"]["after"] =
          coherence_with(measurement, acceleration_mps2, after->residual_N()).coherence;
  }
  const Autocorrelation memory = autocorrelation(measurement, before.residual_N());
  if (!memory.lag_s.empty()) {
    data["autocorrelation"] = {
        {"lag_s", memory.lag_s}, {"residual", memory.correlation}, {"white", memory.white}};
    if (after != nullptr)
      data["autocorrelation"]["after"] = autocorrelation(measurement, after->residual_N()).correlation;
  }
  const AxisResponse measured = response_of(measurement, acceleration_mps2, before.measured_N);
  const bool certain = std::any_of(measured.deviation.begin(), measured.deviation.end(),
                                   [](double one) { return one <= kMostDeviation; });
  if (!certain) return;
  data["response"] = {
      {"frequency_Hz", measured.frequency_Hz},
      {"measured", response_json(measured, measured)},
      {"model", response_json(response_of(measurement, acceleration_mps2, before.model_N), measured)}};
  if (after != nullptr)
    data["response"]["after"] =
        response_json(response_of(measurement, acceleration_mps2, after->model_N), measured);
}

}  // namespace slipstack::workbench
