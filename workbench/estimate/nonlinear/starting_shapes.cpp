// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/starting_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "workbench/base/axis_units.h"
#include "workbench/base/wide_vectors.h"
#include "workbench/estimate/nonlinear/user_effect_starts.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Indices of the local maxima of `power`, the highest first.
std::vector<std::size_t> peaks(const std::vector<double>& power, std::size_t wanted) {
  std::vector<std::size_t> found;
  for (std::size_t i = 1; i + 1 < power.size(); ++i) {
    if (power[i] > power[i - 1] && power[i] >= power[i + 1]) found.push_back(i);
  }
  std::sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) { return power[a] > power[b]; });
  if (found.size() > wanted) found.resize(wanted);
  return found;
}

/// The most periods of a pitch within the stroke that the periodogram over the position contains: a screw of
/// 5 mm on 2.5 m, two periods a turn of the motor of a joint behind a gear of 1:100 over two and a half
/// turns; eight of its bins a period.
constexpr double kMostCycles = 500.0;

double most_cycles(double stroke_m, const ShapeRange& pitch) {
  return std::min(stroke_m / pitch.lower, kMostCycles);
}

/// Segment of the spectrum of the rows in which frequencies are sought.
constexpr std::size_t kFrequencySegment = 512;

/// Step of the periodogram over position, periods within the stroke. Chosen.
constexpr double kCyclesStep = 0.25;

/// Power of the bins at each of `cycles` periods within all bins. Phasors advance by one complex product for
/// each bin instead of a sine and a cosine; eight at once, since each waits for the one before it.
std::vector<double> periodogram(const std::vector<double>& bins, const std::vector<double>& cycles) {
  constexpr std::size_t kAtOnce = 8;
  std::vector<double> power(cycles.size());
  for (std::size_t first = 0; first < cycles.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, cycles.size() - first);
    double step_cos[kAtOnce] = {}, step_sin[kAtOnce] = {};
    for (std::size_t k = 0; k < count; ++k) {
      const double angle = 2.0 * std::numbers::pi * cycles[first + k] / static_cast<double>(bins.size() - 1);
      step_cos[k] = std::cos(angle);
      step_sin[k] = std::sin(angle);
    }
    double re[kAtOnce] = {}, im[kAtOnce] = {}, sines[kAtOnce] = {}, cosines[kAtOnce];
    std::fill_n(cosines, kAtOnce, 1.0);
    run_wide([&] {
      for (const double value : bins) {
        for (std::size_t k = 0; k < kAtOnce; ++k) {
          re[k] += value * cosines[k];
          im[k] += value * sines[k];
          const double next = cosines[k] * step_cos[k] - sines[k] * step_sin[k];
          sines[k] = sines[k] * step_cos[k] + cosines[k] * step_sin[k];
          cosines[k] = next;
        }
      }
    });
    for (std::size_t k = 0; k < count; ++k) power[first + k] = re[k] * re[k] + im[k] * im[k];
  }
  return power;
}

/// Pitches at which `signal` repeats over position: the highest peaks of its periodogram over a uniform grid
/// of positions.
std::vector<double> repeating_pitches(const Measurement& measurement, const ShapeRange& range,
                                      const Eigen::VectorXd& signal, std::size_t wanted) {
  const ValueRange stroke = value_range(measurement.position_m());
  constexpr int kBins = 4096;
  std::vector<double> sum(kBins, 0.0);
  std::vector<double> weight(kBins, 0.0);
  const double bins_per_m = (kBins - 1) / std::max(stroke.length(), 1e-12);
  for (Eigen::Index row = 0; row < signal.size(); ++row) {
    const double x = measurement.position_m()[measurement.row_samples()[static_cast<std::size_t>(row)]];
    const auto bin = static_cast<std::size_t>((x - stroke.low) * bins_per_m);
    sum[bin] += signal(row);
    weight[bin] += 1.0;
  }
  // Every position counts once, however long the axis stood there.
  double mean = 0.0;
  double used = 0.0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (weight[i] == 0.0) continue;
    sum[i] /= weight[i];
    mean += sum[i];
    used += 1.0;
  }
  mean /= std::max(used, 1.0);
  const double lowest_cycles = 1.0;
  const double highest_cycles = most_cycles(stroke.length(), range);
  std::vector<double> cycles;
  for (double c = lowest_cycles; c <= highest_cycles; c += kCyclesStep) cycles.push_back(c);
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = weight[i] > 0.0 ? sum[i] - mean : 0.0;
  const std::vector<double> power = periodogram(sum, cycles);
  std::vector<double> pitches;
  for (const std::size_t peak : peaks(power, wanted)) {
    pitches.push_back(std::clamp(stroke.length() / cycles[peak], range.lower, range.upper));
  }
  return pitches;
}

std::vector<double> pitch_starts(const Measurement& measurement, const ShapeRange& range,
                                 const Eigen::VectorXd& signal) {
  std::vector<double> starts = repeating_pitches(measurement, range, signal, 3);
  // The strongest line may be a harmonic: its double and triple pitch are tried too.
  const std::size_t lines = starts.size();
  for (std::size_t i = 0; i < std::min<std::size_t>(lines, 2); ++i) {
    for (const double multiple : {2.0, 3.0}) {
      if (starts[i] * multiple < range.upper) starts.push_back(starts[i] * multiple);
    }
  }
  if (const auto pitch = measurement.log().magnet_pitch_m) {
    for (const double p : {*pitch, 2.0 * *pitch}) {
      if (p > range.lower && p < range.upper) starts.push_back(p);
    }
  }
  if (axis_is_rotary() && kTurn_rad < range.upper) starts.push_back(kTurn_rad);
  if (starts.empty()) starts.push_back(middle_of(range));
  return starts;
}

/// The residual with the sign of the velocity: what dry friction has in excess.
Eigen::VectorXd along_motion(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  Eigen::VectorXd along_N = residual_N;
  for (Eigen::Index row = 0; row < along_N.size(); ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    if (measurement.velocity_mps()[sample] < 0.0) along_N(row) = -along_N(row);
  }
  return along_N;
}

std::vector<double> frequency_starts(const Measurement& measurement, const ShapeRange& range,
                                     const Eigen::VectorXd& residual_N) {
  const std::span<const double> rows(residual_N.data(), static_cast<std::size_t>(residual_N.size()));
  const Spectrum spectrum = power_spectrum(rows, measurement.row_rate_Hz(), kFrequencySegment);
  std::vector<double> starts = spread(range, 8);
  for (const std::size_t peak : peaks(spectrum.density, 3)) {
    const double frequency = spectrum.frequency_Hz[peak];
    if (frequency > range.lower && frequency < range.upper) starts.push_back(frequency);
  }
  return starts;
}

/// For an effect whose memory can decay with time or with distance: starting points with either one alone.
std::vector<std::vector<double>> with_lag_distances(const std::vector<ShapeRange>& ranges,
                                                    const EffectDescription& effect,
                                                    std::vector<std::vector<double>> points) {
  const ShapeRange* distance = find_range(ranges, effect, ShapeKind::lag_distance);
  const ShapeRange* time = find_range(ranges, effect, ShapeKind::time_constant);
  if (distance == nullptr || time == nullptr) return points;
  std::vector<std::vector<double>> all;
  for (auto& point : points) {
    point[distance->index] = distance->upper;
    all.push_back(point);
    // The same memory as a distance, at the characteristic speed of the effect (its first shape).
    point[distance->index] = std::clamp(point[time->index] * point[0], distance->lower, distance->upper);
    point[time->index] = time->upper;
    all.push_back(point);
  }
  return all;
}

/// Where the search of a delay begins: with none; and, since that does nothing, with that which removes most
/// of the residual to first order, once and twice, since the other effects hold a part of what it explains.
std::vector<double> delay_starts(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const double tick_s = measurement.tick_s();
  const Eigen::VectorXd change_Nps =
      (measurement.force_N({tick_s, 0.0}) - measurement.force_N({-tick_s, 0.0})) / (2.0 * tick_s);
  const double square = change_Nps.squaredNorm();
  const double delay_s = square > 0.0 ? -change_Nps.dot(residual_N) / square : 0.0;
  if (delay_s == 0.0) return {0.0};
  return {0.0, delay_s, 2.0 * delay_s};
}

}  // namespace

std::vector<std::vector<double>> starting_shapes(const Measurement& measurement,
                                                 const EffectDescription& effect,
                                                 const Eigen::VectorXd& residual_N,
                                                 const Eigen::VectorXd& force_N) {
  std::vector<std::vector<double>> points{default_shapes(measurement, effect)};
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, effect);
  if (effect.has_shape(ShapeKind::user_defined))
    return user_effect_starting_shapes(measurement, effect, ranges, residual_N);
  for (const ShapeRange& range : ranges) {
    std::vector<double> values;
    switch (effect.shapes[range.index].kind) {
      case ShapeKind::pitch:
        if (effect.acts_as(Acts::total_scale)) {
          values = pitch_starts(measurement, range, residual_N.cwiseProduct(force_N));
        } else if (effect.acts_as(Acts::dry_scale)) {
          values = pitch_starts(measurement, range, along_motion(measurement, residual_N));
        } else {
          values = pitch_starts(measurement, range, residual_N);
        }
        break;
      case ShapeKind::frequency:
        values = frequency_starts(measurement, range, residual_N);
        break;
      case ShapeKind::exponent:
        values = ranges.size() > 2 ? std::vector{1.0} : std::vector{0.7, 1.2, 2.0};
        break;
      case ShapeKind::delay:
        values = delay_starts(measurement, residual_N);
        break;
      case ShapeKind::damping:
        values = {0.02};
        break;
      case ShapeKind::acceleration:
        values = {range.upper, middle_of(range)};
        break;
      case ShapeKind::lag_distance:
        break;  // set by with_lag_distances() together with the time constant
      default:
        values = spread(range, ranges.size() > 2 ? 5 : 6);
    }
    if (values.empty()) continue;
    std::vector<std::vector<double>> product;
    for (const auto& point : points) {
      for (const double value : values) {
        product.push_back(point);
        product.back()[range.index] = std::clamp(value, range.lower, range.upper);
      }
    }
    points = std::move(product);
  }
  return with_lag_distances(ranges, effect, std::move(points));
}

double independent_values(const Measurement& measurement, const EffectDescription& effect,
                          const ShapeRange& range) {
  const ShapeKind kind = effect.shapes[range.index].kind;
  if (kind == ShapeKind::pitch) {  // one for each period more within the stroke
    const double stroke_m = value_range(measurement.position_m()).length();
    return std::max(1.0, most_cycles(stroke_m, range) - stroke_m / range.upper);
  }
  if (kind == ShapeKind::frequency) {
    const double bin_Hz = measurement.row_rate_Hz() / static_cast<double>(kFrequencySegment);
    return std::max(1.0, (range.upper - range.lower) / bin_Hz);
  }
  return 1.0;
}

}  // namespace slipstack::workbench
