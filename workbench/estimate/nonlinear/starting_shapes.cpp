// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/starting_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <span>
#include <unsupported/Eigen/FFT>

#include "workbench/base/axis_units.h"
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
/// 2 mm on 2 m, two periods a turn of the motor of a joint behind a gear of 1:100 over five turns; eight of
/// its bins a period.
constexpr double kMostCycles = 1000.0;

double most_cycles(double stroke_m, const ShapeRange& pitch) {
  return std::min(stroke_m / pitch.lower, kMostCycles);
}

/// Segment of the spectrum of the rows in which frequencies are sought.
constexpr std::size_t kFrequencySegment = 512;

/// Steps of the periodogram over position in one period within the stroke. Chosen.
constexpr std::size_t kStepsPerCycle = 4;

/// Power of the bins at whole multiples of 1 / kStepsPerCycle periods within all bins, from one period up to
/// `most_cycles`: their Fourier transform, with zeros behind them.
std::vector<double> periodogram(std::vector<double> bins, double most_cycles) {
  bins.resize(kStepsPerCycle * (bins.size() - 1));
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  fft.fwd(transform, bins);
  const auto last = static_cast<std::size_t>(most_cycles * kStepsPerCycle);
  std::vector<double> power;
  for (std::size_t step = kStepsPerCycle; step <= last; ++step) power.push_back(std::norm(transform[step]));
  return power;
}

/// The mean of a signal in bins of equal width over the stroke: every position counts once, however long the
/// axis stood there.
class PositionBins {
 public:
  explicit PositionBins(const Measurement& measurement)
      : position_m_(measurement.position_m()),
        stroke_(value_range(position_m_)),
        bins_per_m_((kBins - 1) / std::max(stroke_.length(), 1e-12)) {}

  double stroke_m() const { return stroke_.length(); }
  void add(std::size_t sample, double value) {
    const auto bin = static_cast<std::size_t>((position_m_[sample] - stroke_.low) * bins_per_m_);
    sum_[bin] += value;
    weight_[bin] += 1.0;
  }
  /// The means less their mean; zero where nothing was added.
  std::vector<double> deviations() const {
    std::vector<double> means(kBins, 0.0);
    double sum = 0.0;
    double used = 0.0;
    for (std::size_t i = 0; i < kBins; ++i) {
      if (weight_[i] == 0.0) continue;
      means[i] = sum_[i] / weight_[i];
      sum += means[i];
      used += 1.0;
    }
    const double mean = sum / std::max(used, 1.0);
    for (std::size_t i = 0; i < kBins; ++i) means[i] = weight_[i] > 0.0 ? means[i] - mean : 0.0;
    return means;
  }

 private:
  static constexpr std::size_t kBins = 8193;  // one more than a power of two: periodogram()
  const std::vector<double>& position_m_;
  ValueRange stroke_;
  double bins_per_m_;
  std::vector<double> sum_ = std::vector<double>(kBins, 0.0);
  std::vector<double> weight_ = std::vector<double>(kBins, 0.0);
};

/// Where a peak lies by the parabola through its bin and the two beside it, in bins.
double top_of_peak(const std::vector<double>& power, std::size_t peak) {
  const double before = power[peak - 1], after = power[peak + 1];
  const double bend = before - 2.0 * power[peak] + after;
  return static_cast<double>(peak) + (bend < 0.0 ? 0.5 * (before - after) / bend : 0.0);
}

/// The highest peaks of the periodogram of the signal in the bins, in periods within the stroke.
struct RepeatingCycles {
  std::vector<double> tried;  ///< of those that were tried, the nearest
  std::vector<double> tops;   ///< by the parabola through its neighbours
};

RepeatingCycles repeating_cycles(const PositionBins& bins, const ShapeRange& range, std::size_t wanted) {
  const std::vector<double> power = periodogram(bins.deviations(), most_cycles(bins.stroke_m(), range));
  constexpr double kStep = 1.0 / kStepsPerCycle;
  RepeatingCycles found;
  for (const std::size_t peak : peaks(power, wanted)) {
    found.tried.push_back(1.0 + kStep * static_cast<double>(peak));
    found.tops.push_back(1.0 + kStep * top_of_peak(power, peak));
  }
  return found;
}

/// The residual with the sign of the velocity: what dry friction has in excess.
double along_motion(const Measurement& measurement, std::size_t sample, double residual_N) {
  return measurement.velocity_mps()[sample] < 0.0 ? -residual_N : residual_N;
}

/// What is sought in the residual: as the effect acts.
double as_it_acts(const Measurement& measurement, const EffectDescription& effect, std::size_t sample,
                  double residual_N, double force_N) {
  if (effect.acts_as(Acts::total_scale)) return residual_N * force_N;
  if (effect.acts_as(Acts::dry_scale)) return along_motion(measurement, sample, residual_N);
  return residual_N;
}

PositionBins bins_of_rows(const Measurement& measurement, const EffectDescription& effect,
                          const Eigen::VectorXd& residual_N, const Eigen::VectorXd& force_N) {
  PositionBins bins(measurement);
  for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    bins.add(sample, as_it_acts(measurement, effect, sample, residual_N(row), force_N(row)));
  }
  return bins;
}

PositionBins bins_of_samples(const Measurement& measurement, const EffectDescription& effect,
                             const std::vector<double>& model_N) {
  PositionBins bins(measurement);
  const std::vector<double>& measured_N = measurement.log().force_N;
  for (const LogPart& part : measurement.parts()) {
    for (const Interval& known : usable_intervals(part, 0)) {
      for (std::size_t i = part.first_sample + known.first; i < part.first_sample + known.end; ++i)
        bins.add(i, as_it_acts(measurement, effect, i, measured_N[i] - model_N[i], measured_N[i]));
    }
  }
  return bins;
}

/// Periods within the stroke at which the residual repeats over the position, the strongest of the rows
/// first. Where the axis passes a pitch faster than the bandwidth of the rows, they see it only where it
/// turns, and any pitch that fits there; the samples see it everywhere. Their peak is taken at its top:
/// beside the true pitch by an eighth of a period, half of the step, a quarter of the amplitude is left, and
/// a wrong pitch may leave less.
std::vector<double> cycles_seen(const Measurement& measurement, const EffectDescription& effect,
                                const ShapeRange& range, const Eigen::VectorXd& residual_N,
                                const Eigen::VectorXd& force_N, const std::vector<double>& model_N) {
  std::vector<double> cycles =
      repeating_cycles(bins_of_rows(measurement, effect, residual_N, force_N), range, 3).tried;
  if (model_N.empty()) return cycles;
  const RepeatingCycles of_samples =
      repeating_cycles(bins_of_samples(measurement, effect, model_N), range, 1);
  cycles.insert(cycles.end(), of_samples.tops.begin(), of_samples.tops.end());
  return cycles;
}

std::vector<double> pitch_starts(const Measurement& measurement, const ShapeRange& range,
                                 const std::vector<double>& cycles) {
  const double stroke_m = measurement.position_range_m().length();
  std::vector<double> starts;
  starts.reserve(2 * cycles.size() + 8);
  for (const double one : cycles) starts.push_back(std::clamp(stroke_m / one, range.lower, range.upper));
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

/// Time constants from which the search of a memory begins: a decade apart, about those that were measured, 1
/// to 50 ms (Armstrong-Helouvry, Dupont, Canudas de Wit 1994).
constexpr std::array kMemories_s{0.003, 0.03, 0.3};

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
                                                 const Eigen::VectorXd& force_N,
                                                 const std::vector<double>& sample_force_N) {
  std::vector<std::vector<double>> points{default_shapes(measurement, effect)};
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, effect);
  if (effect.has_shape(ShapeKind::user_defined))
    return user_effect_starting_shapes(measurement, effect, ranges, residual_N);
  for (const ShapeRange& range : ranges) {
    std::vector<double> values;
    switch (effect.shapes[range.index].kind) {
      case ShapeKind::pitch:
        values = pitch_starts(measurement, range,
                              cycles_seen(measurement, effect, range, residual_N, force_N, sample_force_N));
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
      case ShapeKind::time_constant:
        if (effect.has_shape(ShapeKind::lag_distance)) {
          values.assign(kMemories_s.begin(), kMemories_s.end());
          break;
        }
        [[fallthrough]];
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
    const double stroke_m = measurement.position_range_m().length();
    return std::max(1.0, most_cycles(stroke_m, range) - stroke_m / range.upper);
  }
  if (kind == ShapeKind::frequency) {
    const double bin_Hz = measurement.row_rate_Hz() / static_cast<double>(kFrequencySegment);
    return std::max(1.0, (range.upper - range.lower) / bin_Hz);
  }
  return 1.0;
}

}  // namespace slipstack::workbench
