// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// What an axis at constant velocity adds: the same step from each period to the next.
double drift_per_sample(const std::vector<double>& values, std::size_t period) {
  double sum = 0.0;
  const std::size_t pairs = values.size() - period;
  for (std::size_t i = 0; i < pairs; ++i) sum += values[i + period] - values[i];
  return sum / static_cast<double>(pairs) / static_cast<double>(period);
}

// The complex amplitude of a harmonic, in each period.
std::vector<Complex> harmonic(const std::vector<double>& values, std::size_t period, std::size_t line,
                              double drift) {
  std::vector<Complex> found;
  const double angle = -2.0 * std::numbers::pi * static_cast<double>(line) / static_cast<double>(period);
  for (std::size_t begin = 0; begin + period <= values.size(); begin += period) {
    Complex sum = 0.0;
    const double base = values[begin];
    for (std::size_t i = 0; i < period; ++i) {
      // The product is reduced first: it stays exact for any length.
      const double phase = angle * static_cast<double>(i);
      const double value = values[begin + i] - base - drift * static_cast<double>(i);
      sum += value * Complex(std::cos(phase), std::sin(phase));
    }
    found.push_back(2.0 / static_cast<double>(period) * sum);
  }
  return found;
}

Complex mean_of(const std::vector<Complex>& values) {
  Complex sum = 0.0;
  for (const Complex& value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Σ (a − ā)(b − b̄)* / (n − 1)
Complex covariance(const std::vector<Complex>& a, Complex a_mean, const std::vector<Complex>& b,
                   Complex b_mean) {
  Complex sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - a_mean) * std::conj(b[i] - b_mean);
  return sum / static_cast<double>(a.size() - 1);
}

void append(std::vector<Complex>& all, const std::vector<Complex>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

struct Harmonics {
  std::vector<Complex> position;
  std::vector<Complex> force;
  // Each capture has a phase of its own: the injected force tells it.
  std::vector<Complex> excitation;
};

// All periods of all captures, turned to the phase of the first one. Without a recorded excitation the force
// of each capture's mean tells it.
Harmonics harmonics_of(const std::vector<ExcitedRecord>& captures, std::size_t line,
                       const std::vector<double>& drifts) {
  Harmonics all;
  Complex first = 0.0;
  for (std::size_t c = 0; c < captures.size(); ++c) {
    const ExcitedRecord& record = captures[c];
    const std::size_t period = record.period_samples;
    std::vector<Complex> position = harmonic(record.position_m, period, line, drifts[c]);
    std::vector<Complex> force = harmonic(record.force_N, period, line, 0.0);
    std::vector<Complex> excitation;
    if (!record.excitation.empty()) excitation = harmonic(record.excitation, period, line, 0.0);
    const Complex phase = mean_of(excitation.empty() ? force : excitation);
    if (c == 0) first = phase / std::abs(phase);
    const Complex turn = first * std::abs(phase) / phase;
    for (std::vector<Complex>* values : {&position, &force, &excitation}) {
      for (Complex& value : *values) value *= turn;
    }
    append(all.position, position);
    append(all.force, force);
    append(all.excitation, excitation);
  }
  return all;
}

ResponsePoint point_of(const ExcitedRecord& record, std::size_t line, const Harmonics& all) {
  ResponsePoint point;
  point.frequency_Hz = static_cast<double>(line) * record.line_Hz();
  const auto periods = static_cast<double>(all.position.size());
  // The force is recorded as the mean of two ticks: of what the axis felt, (1 + e^(-jωT)) / 2.
  const double angle = 2.0 * std::numbers::pi * point.frequency_Hz * record.tick_s;
  const Complex held = 2.0 / (1.0 + std::exp(Complex(0.0, -angle)));
  const Complex y = mean_of(all.position);
  const Complex f = mean_of(all.force);
  const double var_y = covariance(all.position, y, all.position, y).real();
  const double var_f = covariance(all.force, f, all.force, f).real();
  const Complex var_yf = covariance(all.position, y, all.force, f);
  point.plant = y / (f * held);
  const double relative =
      var_y / std::norm(y) + var_f / std::norm(f) - 2.0 * (var_yf / (y * std::conj(f))).real();
  point.plant_sd = std::abs(point.plant) * std::sqrt(std::max(relative, 0.0) / periods);
  point.coherence = std::norm(y) / (std::norm(y) + var_y);
  point.sensitivity = Complex(kNotMeasured, kNotMeasured);
  point.sensitivity_sd = kNotMeasured;
  if (all.excitation.empty()) return point;
  const Complex d = mean_of(all.excitation);
  point.sensitivity = f * held / d;
  point.sensitivity_sd = std::abs(held) * std::sqrt(var_f / periods) / std::abs(d);
  return point;
}

void check_alike(const std::vector<ExcitedRecord>& captures, const std::string& name) {
  for (const ExcitedRecord& record : captures) {
    check(record, name);
    const ExcitedRecord& first = captures.front();
    if (record.period_samples == first.period_samples && record.decimation == first.decimation &&
        record.tick_s == first.tick_s && record.lowest == first.lowest && record.highest == first.highest &&
        record.excitation.empty() == first.excitation.empty() && record.at_force == first.at_force)
      continue;
    throw InputError(fmt::format("{}: captures of different excitations", printable(name)));
  }
}

// Over the lines of a band from `low_Hz` to `high_Hz`; infinite where there are none.
double mean_relative_sd(const std::vector<ResponsePoint>& band, double low_Hz, double high_Hz) {
  double sum = 0.0;
  double count = 0.0;
  for (const ResponsePoint& point : band) {
    if (point.frequency_Hz < low_Hz || point.frequency_Hz > high_Hz) continue;
    sum += point.plant_sd / std::abs(point.plant);
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::infinity();
}

// Weighted means of what a mass leaves constant.
ResponsePoint average(const std::vector<ResponsePoint>& group) {
  if (group.size() == 1) return group.front();
  double weights = 0.0;
  double s_weights = 0.0;
  ResponsePoint made;
  Complex curvature = 0.0;
  for (const ResponsePoint& point : group) {
    const double w2 = point.frequency_Hz * point.frequency_Hz;
    const double weight = 1.0 / std::max(std::pow(point.plant_sd * w2, 2), 1e-300);
    weights += weight;
    made.frequency_Hz += point.frequency_Hz * weight;
    curvature += point.plant * w2 * weight;
    const double s_weight = 1.0 / std::max(std::pow(point.sensitivity_sd, 2), 1e-300);
    s_weights += s_weight;
    made.sensitivity += point.sensitivity * s_weight;
    made.coherence += point.coherence / static_cast<double>(group.size());
  }
  made.frequency_Hz /= weights;
  const double w2 = made.frequency_Hz * made.frequency_Hz;
  made.plant = curvature / weights / w2;
  made.plant_sd = 1.0 / std::sqrt(weights) / w2;
  made.sensitivity /= s_weights;
  made.sensitivity_sd = 1.0 / std::sqrt(s_weights);
  return made;
}

}  // namespace

std::vector<ResponsePoint> response(const std::vector<ExcitedRecord>& captures, const std::string& name) {
  check_alike(captures, name);
  const ExcitedRecord& first = captures.front();
  std::vector<double> drifts;
  drifts.reserve(captures.size());
  for (const ExcitedRecord& record : captures)
    drifts.push_back(drift_per_sample(record.position_m, record.period_samples));
  std::vector<ResponsePoint> points;
  for (std::size_t line = first.lowest; line <= first.highest; ++line) {
    const ResponsePoint point = point_of(first, line, harmonics_of(captures, line, drifts));
    // A line at which nothing was excited shows nothing.
    if (std::isfinite(std::abs(point.plant)) && std::isfinite(point.plant_sd) && std::abs(point.plant) > 0.0)
      points.push_back(point);
  }
  if (points.size() < 3) throw InputError(fmt::format("{}: nothing was excited", printable(name)));
  return points;
}

std::vector<ResponsePoint> joined(const std::vector<std::vector<ResponsePoint>>& bands) {
  std::vector<ResponsePoint> all;
  for (const auto& band : bands) {
    for (const ResponsePoint& point : band) {
      const bool better_known = std::any_of(bands.begin(), bands.end(), [&](const auto& other) {
        if (&other == &band) return false;
        const double low_Hz = std::max(band.front().frequency_Hz, other.front().frequency_Hz);
        const double high_Hz = std::min(band.back().frequency_Hz, other.back().frequency_Hz);
        if (point.frequency_Hz < low_Hz || point.frequency_Hz > high_Hz) return false;
        const double own = mean_relative_sd(band, low_Hz, high_Hz);
        const double others = mean_relative_sd(other, low_Hz, high_Hz);
        return others < own || (others == own && &other < &band);
      });
      if (!better_known) all.push_back(point);
    }
  }
  std::sort(all.begin(), all.end(),
            [](const ResponsePoint& a, const ResponsePoint& b) { return a.frequency_Hz < b.frequency_Hz; });
  return all;
}

std::vector<ResponsePoint> smoothed(const std::vector<ResponsePoint>& points, double wanted, double octave) {
  std::vector<ResponsePoint> made;
  std::vector<ResponsePoint> group;
  const double widest = std::exp2(octave);
  for (const ResponsePoint& point : points) {
    if (!group.empty() && point.frequency_Hz > group.front().frequency_Hz * widest) {
      made.push_back(average(group));
      group.clear();
    }
    group.push_back(point);
    const ResponsePoint now = average(group);
    if (now.plant_sd <= wanted * std::abs(now.plant)) {
      made.push_back(now);
      group.clear();
    }
  }
  if (!group.empty()) made.push_back(average(group));
  return made;
}

}  // namespace slipstack::workbench
