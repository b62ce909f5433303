// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/encoder_interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace slipstack::workbench {
namespace {

/// An instant, in samples, at which the position is known.
struct Knot {
  double time;
  double position_m;
};

/// The crossings of cell borders, half-way between the two readings; where several cells are crossed within
/// one sample, the middle of them. The first and the last reading are knots too.
std::vector<Knot> crossings(std::span<const double> position_m) {
  std::vector<Knot> knots{{0.0, position_m.front()}};
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    if (position_m[i] == position_m[i - 1]) continue;
    knots.push_back({static_cast<double>(i) - 0.5, 0.5 * (position_m[i] + position_m[i - 1])});
  }
  knots.push_back({static_cast<double>(position_m.size() - 1), position_m.back()});
  return knots;
}

/// Slope at each knot: of the parabola through it and its neighbours.
std::vector<double> slopes(const std::vector<Knot>& knots) {
  std::vector<double> slope(knots.size(), 0.0);
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    const double before = knots[k].time - knots[k - 1].time;
    const double after = knots[k + 1].time - knots[k].time;
    if (before <= 0.0 || after <= 0.0) continue;
    const double in = (knots[k].position_m - knots[k - 1].position_m) / before;
    const double out = (knots[k + 1].position_m - knots[k].position_m) / after;
    slope[k] = (in * after + out * before) / (before + after);
  }
  return slope;
}

/// The cubic with these values and slopes at both ends of [0, length].
struct Cubic {
  double length;
  double from_m;
  double from_slope;
  double to_m;
  double to_slope;
  double at(double time) const {
    const double t = time / length;
    const double u = 1.0 - t;
    return from_m * u * u * (1.0 + 2.0 * t) + to_m * t * t * (3.0 - 2.0 * t) +
           length * t * u * (from_slope * u - to_slope * t);
  }
};

/// The motion within one cell, between the instants at which it was entered and left.
class Passage {
 public:
  Passage(const Cubic& cubic, double centre_m, double resolution_m)
      : cubic_(cubic), centre_m_(centre_m), half_m_(0.5 * resolution_m) {
    // The tolerance keeps rounding from deciding where the cubic just touches the border.
    const double border_m = (1.0 + 1e-6) * half_m_;
    for (double time = 0.5; time < cubic.length; time += 1.0) {
      stays_inside_ = stays_inside_ && std::abs(cubic.at(time) - centre_m) <= border_m;
    }
  }

  double at(double time) const {
    const double position_m = stays_inside_ ? cubic_.at(time) : stopping_at(time);
    return std::clamp(position_m, centre_m_ - half_m_, centre_m_ + half_m_);
  }

  /// A motion that the readings do not exclude: straight to the first of the two places of `unobserved`, to
  /// the second, and out of the cell; a third of the time each, or entering and leaving at the speeds of the
  /// neighbouring cells.
  double alternative_at(double time, const UnobservedMotion& unobserved) const {
    const double across_m = 2.0 * (centre_m_ - cubic_.from_m);
    const double first_m = cubic_.from_m + unobserved.places[0] * across_m;
    const double second_m = cubic_.from_m + unobserved.places[1] * across_m;
    const double third = cubic_.length / 3.0;
    const double arrives = unobserved.at_speed ? std::min(third, ramp(cubic_.from_slope)) : third;
    const double departs =
        cubic_.length - (unobserved.at_speed ? std::min(third, ramp(cubic_.to_slope)) : third);
    if (time < arrives) return std::lerp(cubic_.from_m, first_m, time / arrives);
    if (time < departs) return std::lerp(first_m, second_m, (time - arrives) / (departs - arrives));
    return std::lerp(second_m, cubic_.to_m, (time - departs) / (cubic_.length - departs));
  }

 private:
  /// The axis entered so fast and stayed so long that it must have stopped within the cell. Where is unknown:
  /// the centre is taken, with constant deceleration before and constant acceleration after it.
  double stopping_at(double time) const {
    const double braking = ramp(cubic_.from_slope);
    const double starting = ramp(cubic_.to_slope);
    if (time < braking) return Cubic{braking, cubic_.from_m, cubic_.from_slope, centre_m_, 0.0}.at(time);
    const double left = cubic_.length - time;
    if (left < starting) {
      return Cubic{starting, centre_m_, 0.0, cubic_.to_m, cubic_.to_slope}.at(starting - left);
    }
    return centre_m_;
  }
  /// Time from a border to the centre, in samples.
  double ramp(double slope) const {
    const double longest = 0.5 * cubic_.length;
    return 2.0 * half_m_ < longest * std::abs(slope) ? 2.0 * half_m_ / std::abs(slope) : longest;
  }

  Cubic cubic_;
  double centre_m_;
  double half_m_;
  bool stays_inside_ = true;
};

/// The motion is unsteady where the axis stays in a cell this many times longer than in a neighbouring one;
/// chosen.
constexpr double kUnsteady = 3.0;

/// Whether the readings leave open how the axis moved from knot k to the next.
bool is_unobserved(const std::vector<Knot>& knots, std::size_t k, double longest_known) {
  const double stay = knots[k + 1].time - knots[k].time;
  if (stay <= longest_known) return false;
  const bool whole = k > 0 && k + 2 < knots.size();
  if (!whole || knots[k].position_m == knots[k + 1].position_m) return true;
  const double before = knots[k].time - knots[k - 1].time;
  const double after = knots[k + 2].time - knots[k + 1].time;
  return stay > kUnsteady * std::min(before, after);
}

}  // namespace

std::vector<double> interpolate_between_steps(std::span<const double> position_m, double resolution_m,
                                              const UnobservedMotion& unobserved) {
  std::vector<double> smooth(position_m.begin(), position_m.end());
  if (resolution_m <= 0.0 || position_m.size() < 3) return smooth;
  const std::vector<Knot> knots = crossings(position_m);
  const std::vector<double> slope = slopes(knots);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double length = knots[k + 1].time - knots[k].time;
    // In a cell that is crossed within two samples the crossings add nothing to the readings.
    if (length < 2.0) continue;
    const auto first = static_cast<std::size_t>(std::ceil(knots[k].time));
    const Passage passage({length, knots[k].position_m, slope[k], knots[k + 1].position_m, slope[k + 1]},
                          position_m[first], resolution_m);
    const bool unknown = is_unobserved(knots, k, unobserved.longest_known);
    for (std::size_t i = first; i < smooth.size() && static_cast<double>(i) < knots[k + 1].time; ++i) {
      const double time = static_cast<double>(i) - knots[k].time;
      smooth[i] = unknown ? passage.alternative_at(time, unobserved) : passage.at(time);
    }
  }
  return smooth;
}

}  // namespace slipstack::workbench
