// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/search_ranges.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "workbench/base/axis_units.h"
#include "workbench/model/effect_adapters/shape_parameter.h"

namespace slipstack::workbench {
namespace {

double largest_magnitude(const std::vector<double>& values) {
  const ValueRange extent = value_range(values);
  return std::max(-extent.low, extent.high);
}

/// Below this velocity the axis moves less than ten encoder steps in one period of the bandwidth. An effect
/// of velocity cannot be distinguished from an effect of displacement there.
double slowest_visible_mps(const Measurement& measurement) {
  return std::max(axis_length(1e-6), 10.0 * measurement.encoder_resolution_m() * measurement.bandwidth_Hz());
}

/// Bounds of a shape of a user-defined effect: as declared, or else the range of the log in its unit.
ShapeRange user_range(const Measurement& measurement, const ShapeSpec& spec, std::size_t index) {
  ShapeRange range{index, static_cast<double>(spec.lower), static_cast<double>(spec.upper), false};
  if (spec.upper < kUnbounded || spec.lower > -kUnbounded) {
    range.logarithmic = range.lower > 0.0 && range.upper > 3.0 * range.lower;
    return range;
  }
  const std::string unit = linear_unit(spec.unit);
  if (unit == "m") {
    const ValueRange stroke = measurement.position_range_m();
    return {index, stroke.low, stroke.high, false, (stroke.high - stroke.low) / 256.0};
  }
  if (unit == "s") return {index, measurement.tick_s(), 10.0 * measurement.duration_s(), true};
  const double largest = unit == "m/s" ? largest_magnitude(measurement.velocity_mps())
                                       : largest_magnitude(measurement.acceleration_mps2());
  return {index, -largest, largest, false};
}

bool changes_over_log(const EffectDescription& effect) {
  return effect.has_shape(ShapeKind::duration);
}

/// A time constant that is so many times as long as the log is none: what is seen is the beginning of an
/// exponential, which deviates from a straight line by an eighth of their ratio. Memories of the velocity are
/// without end then; a change over the log is in proportion to time, to a per mille of itself.
constexpr double kEndlessMemory = 10.0;
constexpr double kStraightLine = 100.0;

/// How far above the band a mode may lie, in bandwidths: at the end of the band it then multiplies its mass
/// by 3.3, which no payload does. With 1.5 (by 1.8) a payload of 112 training logs of joints was taken for a
/// mode.
constexpr double kBeyondBand = 1.2;

/// How far a pitch may be from one turn to be that of gravity or of an eccentric part. Chosen.
constexpr double kAboutOneTurn = 0.03;

/// The part of a turn that shows more than a line with a bend.
constexpr double kShowsTurn = 0.5;

/// A period that does not fit twice into the stroke cannot be observed as a repetition. One turn need not be
/// observed: an angle repeats after it. Of a change of friction or of the motor less than half of one shows
/// no more than a line with a bend; gravity has a known form, of which a cubic leaves 1.2e-4 over an eighth
/// of a turn, and more beyond (2 J4 of half the travel).
double longest_pitch_m(const Measurement& measurement, const EffectDescription& effect) {
  const double stroke_m = measurement.position_range_m().length();
  const double least_turns = effect.acts_as(Acts::force) ? 0.125 : kShowsTurn;
  const bool shows_turn = axis_is_rotary() && stroke_m > least_turns * kTurn_rad;
  return std::max(0.5 * stroke_m, shows_turn ? kTurn_rad : 0.0);
}

/// Intersection of the catalogue's bounds with what the log shows.
ShapeRange narrowed(const Measurement& measurement, const EffectDescription& effect, std::size_t index) {
  const ShapeSpec& spec = effect.shapes[index];
  if (spec.kind == ShapeKind::user_defined) return user_range(measurement, spec, index);
  const ShapeBounds bounds = bounds_of(spec);
  ShapeRange range{index, bounds.lower, bounds.upper, true};
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
      narrow(measurement.encoder_resolution_m(), 10.0 * measurement.position_range_m().length());
      break;
    case ShapeKind::time_constant:
      narrow(measurement.tick_s(), changes_over_log(effect) ? kStraightLine * measurement.longest_log_s()
                                                            : kEndlessMemory * measurement.duration_s());
      break;
    case ShapeKind::pitch:
      narrow(20.0 * measurement.encoder_resolution_m(), longest_pitch_m(measurement, effect));
      range.repeats_over_m = measurement.position_range_m().length();
      break;
    case ShapeKind::frequency:
      narrow(4.0 / (static_cast<double>(measurement.sample_count()) * measurement.tick_s()),
             kBeyondBand * measurement.bandwidth_Hz());
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
         kind != ShapeKind::duration && kind != ShapeKind::table && !is_nominal(kind);
}

/// The value of a shape until all other effects are identified.
double nominal(ShapeKind kind, const ShapeRange& range) {
  return kind == ShapeKind::filter ? 0.0 : middle_of(range);
}

}  // namespace

const ShapeRange* find_range(const std::vector<ShapeRange>& ranges, const EffectDescription& effect,
                             ShapeKind kind) {
  for (const ShapeRange& range : ranges) {
    if (effect.shapes[range.index].kind == kind) return &range;
  }
  return nullptr;
}

bool is_about_one_turn(double pitch_m) {
  return axis_is_rotary() && std::abs(pitch_m / kTurn_rad - 1.0) < kAboutOneTurn;
}

bool bends_like_one_turn(const Measurement& measurement, const Terms& terms) {
  const double travel_m = measurement.position_range_m().length();
  return axis_is_rotary() && travel_m < kTurn_rad &&
         std::any_of(terms.begin(), terms.end(), [](const Term& term) {
           const auto pitch_m = term.shape(ShapeKind::pitch);
           return term.effect->acts_as(Acts::force) &&
                  (term.effect->has_shape(ShapeKind::travel) || (pitch_m && is_one_turn(*pitch_m)));
         });
}

bool is_one_turn(double pitch_m) {
  return axis_is_rotary() && pitch_m == kTurn_rad;
}

void settle_pitch(const Measurement& measurement, Term& term) {
  const auto index = term.effect->find_shape(ShapeKind::pitch);
  if (!index) return;
  // The longest pitch of a search is half of the travel but for the rounding of a logarithm.
  constexpr double kRounding = 1e-9;
  const double seen_m = (1.0 + kRounding) * 0.5 * measurement.position_range_m().length();
  double& pitch_m = term.shapes[*index];
  if (axis_is_rotary() && pitch_m > seen_m) pitch_m = kTurn_rad;
  const GainGroup& group = term.effect->gain_groups.front();
  for (std::size_t i = 0; i < term.gains.size(); ++i) {
    const std::size_t harmonic = i % term.gains_per_set() / 2 + 1;  // each has a cosine and a sine
    const bool seen = harmonic == 1 || pitch_m / static_cast<double>(harmonic) <= seen_m;
    term.lower[i] = seen ? static_cast<double>(group.lower) : 0.0;
    term.upper[i] = seen ? static_cast<double>(group.upper) : 0.0;
  }
}

bool is_at_bound(const ShapeRange& range, double value) {
  constexpr double kRounding = 1e-6;  // of the range
  const double margin = kRounding * (range.upper - range.lower);
  return value <= range.lower + margin || value >= range.upper - margin;
}

double middle_of(const ShapeRange& range) {
  return range.logarithmic ? std::sqrt(range.lower * range.upper) : 0.5 * (range.lower + range.upper);
}

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
    if (is_searched(effect.shapes[i].kind)) ranges.push_back(narrowed(measurement, effect, i));
  }
  return ranges;
}

bool period_fits(const Measurement& measurement, const EffectDescription& effect) {
  const double travel_m = measurement.position_range_m().length();
  return std::none_of(effect.shapes.begin(), effect.shapes.end(), [&](const ShapeSpec& shape) {
    return shape.kind == ShapeKind::pitch && 2.0 * static_cast<double>(shape.lower) > travel_m;
  });
}

std::vector<ShapeRange> nominal_shapes(const Measurement& measurement, const EffectDescription& effect) {
  std::vector<ShapeRange> ranges;
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    if (!is_nominal(effect.shapes[i].kind)) continue;
    ranges.push_back(narrowed(measurement, effect, i));
    ranges.back().nominal = nominal(effect.shapes[i].kind, ranges.back());
  }
  return ranges;
}

std::vector<double> default_shapes(const Measurement& measurement, const EffectDescription& effect) {
  const ValueRange stroke = measurement.position_range_m();
  std::vector<double> shapes;
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    const ShapeSpec& spec = effect.shapes[i];
    switch (spec.kind) {
      case ShapeKind::slip_distance: {
        if (measurement.slip_distances_m().size() == effect.shapes.size()) {
          return measurement.slip_distances_m();
        }
        // From below the encoder's step to beyond any pre-sliding travel of a rolling guideway, but no
        // further than the travel of this log.
        const double longest = std::min(stroke.length(), longest_slip_m());
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
      case ShapeKind::duration:
        shapes.push_back(std::max(measurement.longest_log_s(), static_cast<double>(spec.lower)));
        break;
      case ShapeKind::exponent:
        shapes.push_back(1.0);
        break;
      default:
        shapes.push_back(nominal(spec.kind, narrowed(measurement, effect, i)));
    }
  }
  return shapes;
}

}  // namespace slipstack::workbench
