// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/shape_search.h"

#include <algorithm>
#include <cmath>
#include <nlopt.hpp>
#include <numbers>

#include "workbench/estimate/nonlinear/user_effect_starts.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

struct Swept {
  double low;
  double high;
  double length() const { return high - low; }
};

Swept extent_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

double largest_magnitude(const std::vector<double>& values) {
  const Swept extent = extent_of(values);
  return std::max(-extent.low, extent.high);
}

/// Below this an axis has not moved ten encoder steps in one period of the bandwidth: what looks like an
/// effect of velocity is one of displacement there.
double slowest_visible_mps(const Measurement& measurement) {
  return std::max(1e-6, 10.0 * measurement.encoder_resolution_m() * measurement.bandwidth_Hz());
}

/// Bounds of a user's own shape: as they were given, or what the log shows of its unit.
ShapeRange user_range(const Measurement& measurement, const ShapeSpec& spec, std::size_t index) {
  ShapeRange range{index, static_cast<double>(spec.lower), static_cast<double>(spec.upper), false};
  if (spec.upper < kUnbounded || spec.lower > -kUnbounded) {
    range.logarithmic = range.lower > 0.0 && range.upper > 3.0 * range.lower;
    return range;
  }
  const std::string_view unit = spec.unit;
  if (unit == "m") {
    const Swept stroke = extent_of(measurement.position_m());
    return {index, stroke.low, stroke.high, false, (stroke.high - stroke.low) / 256.0};
  }
  if (unit == "s") return {index, measurement.tick_s(), 10.0 * measurement.duration_s(), true};
  const double largest = unit == "m/s" ? largest_magnitude(measurement.velocity_mps())
                                       : largest_magnitude(measurement.acceleration_mps2());
  return {index, -largest, largest, false};
}

/// Intersection of the catalogue's bounds with what the log shows.
ShapeRange narrowed(const Measurement& measurement, const ShapeSpec& spec, std::size_t index) {
  if (spec.kind == ShapeKind::user_defined) return user_range(measurement, spec, index);
  ShapeRange range{index, static_cast<double>(spec.lower), static_cast<double>(spec.upper), true};
  const auto narrow = [&range](double low, double high) {
    range.lower = std::clamp(low, range.lower, range.upper);
    range.upper = std::clamp(high, range.lower, range.upper);
  };
  switch (spec.kind) {
    case ShapeKind::velocity:
    case ShapeKind::fading_velocity:
      narrow(slowest_visible_mps(measurement), largest_magnitude(measurement.velocity_mps()));
      break;
    case ShapeKind::exponent:
    case ShapeKind::nominal_exponent:
    case ShapeKind::delay:
    case ShapeKind::filter:
      range.logarithmic = false;
      break;
    case ShapeKind::acceleration: {
      const double largest = largest_magnitude(measurement.acceleration_mps2());
      narrow(0.05 * largest, 20.0 * largest);
      break;
    }
    case ShapeKind::lag_distance:
      narrow(measurement.encoder_resolution_m(), 10.0 * extent_of(measurement.position_m()).length());
      break;
    case ShapeKind::time_constant:
      narrow(measurement.tick_s(), 10.0 * measurement.duration_s());
      break;
    case ShapeKind::pitch:
      // What does not repeat twice within the stroke is not seen to repeat.
      narrow(20.0 * measurement.encoder_resolution_m(), 0.5 * extent_of(measurement.position_m()).length());
      break;
    case ShapeKind::frequency:
      narrow(4.0 / (static_cast<double>(measurement.sample_count()) * measurement.tick_s()),
             measurement.bandwidth_Hz());
      break;
    default:
      break;
  }
  return range;
}

bool is_nominal(ShapeKind kind) {
  return kind == ShapeKind::nominal_exponent || kind == ShapeKind::filter;
}

bool is_searched(ShapeKind kind) {
  return kind != ShapeKind::slip_distance && kind != ShapeKind::position && kind != ShapeKind::travel &&
         !is_nominal(kind);
}

double middle(const ShapeRange& range) {
  return range.logarithmic ? std::sqrt(range.lower * range.upper) : 0.5 * (range.lower + range.upper);
}

/// What a shape is until all else is known.
double nominal(ShapeKind kind, const ShapeRange& range) {
  return kind == ShapeKind::filter ? 0.0 : middle(range);
}

/// Local maxima of `power`, the highest first.
std::vector<std::size_t> peaks(const std::vector<double>& power, std::size_t wanted) {
  std::vector<std::size_t> found;
  for (std::size_t i = 1; i + 1 < power.size(); ++i) {
    if (power[i] > power[i - 1] && power[i] >= power[i + 1]) found.push_back(i);
  }
  std::sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) { return power[a] > power[b]; });
  if (found.size() > wanted) found.resize(wanted);
  return found;
}

/// Pitches at which `signal` repeats over position: peaks of its periodogram over a uniform position grid.
std::vector<double> repeating_pitches(const Measurement& measurement, const ShapeRange& range,
                                      const Eigen::VectorXd& signal, std::size_t wanted) {
  const Swept stroke = extent_of(measurement.position_m());
  constexpr int kSpectrumBins = 4096;
  std::vector<double> sum(kSpectrumBins, 0.0);
  std::vector<double> weight(kSpectrumBins, 0.0);
  const double bins_per_m = (kSpectrumBins - 1) / std::max(stroke.length(), 1e-12);
  for (Eigen::Index row = 0; row < signal.size(); ++row) {
    const double x = measurement.position_m()[measurement.row_samples()[static_cast<std::size_t>(row)]];
    const auto bin = static_cast<std::size_t>((x - stroke.low) * bins_per_m);
    sum[bin] += signal(row);
    weight[bin] += 1.0;
  }
  // A bin counts once, however long the axis stayed there.
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
  const double highest_cycles = std::min(stroke.length() / range.lower, 150.0);
  constexpr double kStep = 0.25;
  std::vector<double> cycles;
  std::vector<double> power;
  for (double c = lowest_cycles; c <= highest_cycles; c += kStep) {
    double re = 0.0;
    double im = 0.0;
    const double turn = 2.0 * std::numbers::pi * c / (kSpectrumBins - 1);
    // Rotation by recurrence: one complex product a bin.
    const double cr = std::cos(turn), sr = std::sin(turn);
    double ci = 1.0, si = 0.0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      if (weight[i] > 0.0) {
        re += (sum[i] - mean) * ci;
        im += (sum[i] - mean) * si;
      }
      const double next = ci * cr - si * sr;
      si = si * cr + ci * sr;
      ci = next;
    }
    cycles.push_back(c);
    power.push_back(re * re + im * im);
  }
  std::vector<double> pitches;
  for (const std::size_t peak : peaks(power, wanted)) {
    pitches.push_back(std::clamp(stroke.length() / cycles[peak], range.lower, range.upper));
  }
  return pitches;
}

std::vector<double> pitch_starts(const Measurement& measurement, const ShapeRange& range,
                                 const Eigen::VectorXd& signal) {
  std::vector<double> starts = repeating_pitches(measurement, range, signal, 3);
  // The strongest line may be a harmonic of the pitch.
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
  if (starts.empty()) starts.push_back(middle(range));
  return starts;
}

std::vector<double> frequency_starts(const Measurement& measurement, const ShapeRange& range,
                                     const Eigen::VectorXd& residual_N) {
  const double row_rate_Hz = measurement.sample_rate_Hz() / static_cast<double>(measurement.row_stride());
  const std::span<const double> rows(residual_N.data(), static_cast<std::size_t>(residual_N.size()));
  const Spectrum spectrum = power_spectrum(rows, row_rate_Hz, 512);
  std::vector<double> starts = spread(range, 8);
  for (const std::size_t peak : peaks(spectrum.density, 3)) {
    const double frequency = spectrum.frequency_Hz[peak];
    if (frequency > range.lower && frequency < range.upper) starts.push_back(frequency);
  }
  return starts;
}

/// An effect whose memory may fade with time or with distance starts from either alone.
std::vector<std::vector<double>> with_lag_distances(const std::vector<ShapeRange>& ranges,
                                                    const EffectDescription& effect,
                                                    std::vector<std::vector<double>> points) {
  const auto is_kind = [&](ShapeKind kind) {
    return [&effect, kind](const ShapeRange& range) { return effect.shapes[range.index].kind == kind; };
  };
  const auto distance = std::find_if(ranges.begin(), ranges.end(), is_kind(ShapeKind::lag_distance));
  const auto time = std::find_if(ranges.begin(), ranges.end(), is_kind(ShapeKind::time_constant));
  if (distance == ranges.end() || time == ranges.end()) return points;
  std::vector<std::vector<double>> all;
  for (auto& point : points) {
    point[distance->index] = distance->upper;
    all.push_back(point);
    // The same memory at the speed at which the effect acts.
    point[distance->index] = std::clamp(point[time->index] * point[0], distance->lower, distance->upper);
    point[time->index] = time->upper;
    all.push_back(point);
  }
  return all;
}

}  // namespace

std::vector<double> spread(const ShapeRange& range, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    values.push_back(range.logarithmic ? range.lower * std::pow(range.upper / range.lower, t)
                                       : range.lower + t * (range.upper - range.lower));
  }
  return values;
}

std::vector<double> slip_distances(double shortest_m, double longest_m, std::size_t count,
                                   std::size_t capacity) {
  std::vector<double> distances(capacity, 0.0);
  for (std::size_t i = 0; i < std::min(count, capacity); ++i) {
    const double t = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    distances[i] = shortest_m * std::pow(longest_m / shortest_m, t);
  }
  return distances;
}

std::vector<ShapeRange> searched_shapes(const Measurement& measurement, const EffectDescription& effect) {
  std::vector<ShapeRange> ranges;
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    if (is_searched(effect.shapes[i].kind)) ranges.push_back(narrowed(measurement, effect.shapes[i], i));
  }
  return ranges;
}

std::vector<ShapeRange> nominal_shapes(const Measurement& measurement, const EffectDescription& effect) {
  std::vector<ShapeRange> ranges;
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    if (!is_nominal(effect.shapes[i].kind)) continue;
    ranges.push_back(narrowed(measurement, effect.shapes[i], i));
    ranges.back().nominal = nominal(effect.shapes[i].kind, ranges.back());
  }
  return ranges;
}

std::vector<double> default_shapes(const Measurement& measurement, const EffectDescription& effect) {
  const Swept stroke = extent_of(measurement.position_m());
  std::vector<double> shapes;
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    const ShapeSpec& spec = effect.shapes[i];
    switch (spec.kind) {
      case ShapeKind::slip_distance: {
        if (measurement.slip_distances_m().size() == effect.shapes.size()) {
          return measurement.slip_distances_m();
        }
        // From below the encoder's step to beyond any pre-sliding travel of a rolling guideway, or to the
        // largest travel of this log.
        const double longest = std::min(stroke.length(), kLongestSlip_m);
        const double step = std::max(measurement.encoder_resolution_m(), 1e-9);
        const double shortest = std::clamp(0.5 * step, longest * 1e-5, longest * 0.1);
        return slip_distances(shortest, longest, effect.shapes.size(), effect.shapes.size());
      }
      case ShapeKind::position:
        shapes.push_back(stroke.low);
        break;
      case ShapeKind::travel:
        shapes.push_back(std::max(stroke.length(), static_cast<double>(spec.lower)));
        break;
      case ShapeKind::exponent:
        shapes.push_back(1.0);
        break;
      default:
        shapes.push_back(nominal(spec.kind, narrowed(measurement, spec, i)));
    }
  }
  return shapes;
}

std::vector<std::vector<double>> starting_shapes(const Measurement& measurement,
                                                 const EffectDescription& effect,
                                                 const Eigen::VectorXd& residual_N,
                                                 const Eigen::VectorXd& force_N) {
  std::vector<std::vector<double>> points{default_shapes(measurement, effect)};
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, effect);
  const bool own = std::any_of(effect.shapes.begin(), effect.shapes.end(),
                               [](const ShapeSpec& shape) { return shape.kind == ShapeKind::user_defined; });
  if (own) return user_effect_starting_shapes(measurement, effect, ranges, residual_N);
  for (const ShapeRange& range : ranges) {
    std::vector<double> values;
    switch (effect.shapes[range.index].kind) {
      case ShapeKind::pitch:
        if (effect.acts_as(Acts::total_scale)) {
          values = pitch_starts(measurement, range, residual_N.cwiseProduct(force_N));
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
        values = {0.0};
        break;
      case ShapeKind::damping:
        values = {0.02};
        break;
      case ShapeKind::acceleration:
        values = {range.upper, middle(range)};
        break;
      case ShapeKind::lag_distance:
        break;  // with the time constant, below
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

SearchResult refine_shapes(const std::vector<ShapeRange>& ranges, std::vector<double> start,
                           const std::function<double(const std::vector<double>&)>& cost, int evaluations) {
  SearchResult best{start, cost(start)};
  if (ranges.empty()) return best;
  const auto to_search = [&](const ShapeRange& range, double value) {
    return range.logarithmic ? std::log(value) : value;
  };
  std::vector<double> lower, upper, point, step;
  for (const ShapeRange& range : ranges) {
    lower.push_back(to_search(range, range.lower));
    upper.push_back(to_search(range, range.upper));
    point.push_back(std::clamp(to_search(range, start[range.index]), lower.back(), upper.back()));
    if (range.first_step > 0.0) {
      step.push_back(range.first_step);
      continue;
    }
    step.push_back(std::max(1e-12, range.logarithmic ? std::min(0.25, 0.25 * (upper.back() - lower.back()))
                                                     : 0.1 * (upper.back() - lower.back())));
  }
  auto objective = [&](const std::vector<double>& x) {
    std::vector<double> shapes = start;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      shapes[ranges[i].index] = ranges[i].logarithmic ? std::exp(x[i]) : x[i];
    }
    const double value = cost(shapes);
    if (value < best.cost) best = {shapes, value};
    return value;
  };
  using Objective = decltype(objective);
  nlopt::opt search(nlopt::LN_NELDERMEAD, static_cast<unsigned>(ranges.size()));
  search.set_min_objective([](const std::vector<double>& x, std::vector<double>&,
                              void* data) { return (*static_cast<Objective*>(data))(x); },
                           &objective);
  search.set_lower_bounds(lower);
  search.set_upper_bounds(upper);
  search.set_initial_step(step);
  search.set_maxeval(evaluations);
  search.set_ftol_rel(1e-5);
  double value = best.cost;
  try {
    search.optimize(point, value);
  } catch (const nlopt::roundoff_limited&) {
    // As good as it gets: the best point seen stands.
  }
  return best;
}

}  // namespace slipstack::workbench
