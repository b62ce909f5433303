// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/user_table.h"

#include <fmt/format.h>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/effects/numerics/user_table.h"
#include "workbench/base/errors.h"
#include "workbench/base/linear_systems.h"
#include "workbench/estimate/terms/user_force.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kIntervals = kUserTablePoints - 1;
constexpr double kLargestShare = 0.01;  ///< largest error of a table, relative to the peak; chosen
/// Below this fraction of the fastest speed the sign of velocity is replaced by a slope, so that the force
/// does not jump at standstill. Chosen.
constexpr double kReversalShare = 1.0 / 500;
constexpr std::size_t kGrid = 1U << 15;  ///< intervals of the grid on which tables are compared

/// The force along the coordinate of the table, divided by the sign of velocity where the table is multiplied
/// by it.
class Profile {
 public:
  Profile(UserForce& force, bool over_velocity, bool by_direction, double middle_m, double top_mps)
      : force_(force),
        over_velocity_(over_velocity),
        by_direction_(by_direction),
        middle_m_(middle_m),
        top_mps_(top_mps) {}

  bool over_velocity() const { return over_velocity_; }
  bool by_direction() const { return by_direction_; }

  std::vector<double> at(const std::vector<double>& places) const {
    std::vector<Sample<double>> samples(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      samples[i].position_m = over_velocity_ ? middle_m_ : places[i];
      samples[i].velocity_mps = over_velocity_ ? moving(places[i]) : 0.5 * top_mps_;
    }
    std::vector<double> values = force_.at(samples);
    if (by_direction_ && over_velocity_) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = std::copysign(1.0, samples[i].velocity_mps) * values[i];
      }
    }
    return values;
  }

 private:
  // The velocity, but not exactly zero where the force has a step there.
  double moving(double velocity_mps) const {
    if (!by_direction_ || std::abs(velocity_mps) > 1e-9 * top_mps_) return velocity_mps;
    return std::copysign(1e-9 * top_mps_, velocity_mps);
  }

  UserForce& force_;
  bool over_velocity_;
  bool by_direction_;
  double middle_m_;
  double top_mps_;
};

std::vector<double> evenly(double from, double to, std::size_t count) {
  std::vector<double> places(count);
  for (std::size_t i = 0; i < count; ++i) {
    places[i] = from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1);
  }
  return places;
}

/// A piecewise linear function through evenly spaced points, constant beyond either end.
struct Lines {
  double from = 0.0;
  double to = 1.0;
  std::array<double, kUserTablePoints> points{};

  /// The interval that contains a place, and the fraction of it before the place.
  std::pair<std::size_t, double> place_of(double u) const {
    const double place = std::clamp((u - from) / (to - from), 0.0, 1.0) * static_cast<double>(kIntervals);
    const std::size_t interval = std::min(static_cast<std::size_t>(place), kIntervals - 1);
    return {interval, place - static_cast<double>(interval)};
  }
  double at(double u) const {
    const auto [i, t] = place_of(u);
    return points[i] + t * (points[i + 1] - points[i]);
  }
};

/// The points by least squares, over evenly spaced places within [from, to] and some outside.
Lines fitted_lines(const Profile& profile, double lower, double upper, double from, double to) {
  Lines lines{from, to, {}};
  std::vector<double> places = evenly(from, to, 24 * kIntervals + 1);
  for (const double u : evenly(lower, upper, 400)) {
    if (u < from || u > to) places.push_back(u);
  }
  const std::vector<double> values = profile.at(places);
  constexpr auto kCount = static_cast<Eigen::Index>(kUserTablePoints);
  Eigen::MatrixXd normal = 1e-9 * Eigen::MatrixXd::Identity(kCount, kCount);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kCount);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto [interval, t] = lines.place_of(places[k]);
    const auto i = static_cast<Eigen::Index>(interval);
    const Eigen::Vector2d weights(1.0 - t, t);
    normal.block<2, 2>(i, i) += weights * weights.transpose();
    right.segment<2>(i) += values[k] * weights;
  }
  const Eigen::VectorXd solved = solve_symmetric(normal, right);
  std::copy(solved.data(), solved.data() + kCount, lines.points.begin());
  return lines;
}

struct Fitted {
  Lines lines;
  double largest_error_N = HUGE_VAL;
};

/// The best fit over several choices of [from, to]. Each leaves out the ends of the range where the profile
/// differs from its end value by less than a tolerance, with the tolerance increasing.
Fitted best_lines(const Profile& profile, double lower, double upper, double peak_N) {
  const std::vector<double> grid = evenly(lower, upper, kGrid + 1);
  const std::vector<double> values = profile.at(grid);
  Fitted best;
  for (const double share : {0.0, 1e-4, 3e-4, 1e-3, 2e-3, 4e-3, 7e-3}) {
    const double apart_N = std::max(share, kSameForce) * peak_N;
    std::size_t first = 0;
    std::size_t last = grid.size() - 1;
    while (first + 2 < grid.size() && std::abs(values[first + 1] - values.front()) <= apart_N) ++first;
    while (last > first + 1 && std::abs(values[last - 1] - values.back()) <= apart_N) --last;
    Fitted one{fitted_lines(profile, lower, upper, grid[first], grid[last]), 0.0};
    const auto judge = [&](const std::vector<double>& places, const std::vector<double>& wanted) {
      for (std::size_t i = 0; i < places.size(); ++i) {
        one.largest_error_N = std::max(one.largest_error_N, std::abs(one.lines.at(places[i]) - wanted[i]));
      }
    };
    judge(grid, values);
    const std::vector<double> inside = evenly(grid[first], grid[last], 64 * kIntervals + 1);
    judge(inside, profile.at(inside));
    if (one.largest_error_N < best.largest_error_N) best = one;
  }
  return best;
}

TabulatedEffect table_of(const Profile& profile, const Fitted& fitted, double peak_N, double top_mps) {
  TabulatedEffect table;
  const Lines& lines = fitted.lines;
  const double per_unit = static_cast<double>(kIntervals) / (lines.to - lines.from);
  const EffectDescription& effect = controller_table();
  table.term.effect = &effect;
  table.over_velocity = profile.over_velocity();
  table.from = lines.from;
  table.to = lines.to;
  if (profile.by_direction()) table.reversal_velocity_mps = std::clamp(kReversalShare * top_mps, 1e-6, 1.0);
  table.term.shapes = table.over_velocity
                          ? std::vector<double>{0.0, 0.0, lines.from, per_unit, table.reversal_velocity_mps}
                          : std::vector<double>{lines.from, per_unit, 0.0, 0.0, table.reversal_velocity_mps};
  table.term.gains.assign(lines.points.begin(), lines.points.end());
  table.term.lower.assign(kUserTablePoints, static_cast<double>(effect.gain_groups[0].lower));
  table.term.upper.assign(kUserTablePoints, static_cast<double>(effect.gain_groups[0].upper));
  table.largest_error_N = fitted.largest_error_N;
  table.peak_N = peak_N;
  return table;
}

Tabulated tabulate_form(const Measurement& measurement, UserForce& force, double allowed_N) {
  const ValueRange travel = measurement.position_range_m();
  double top_mps = 0.0;
  for (const double v : measurement.velocity_mps()) top_mps = std::max(top_mps, std::abs(v));
  if (!(top_mps > 0.0)) return {std::nullopt, "the log shows no motion"};
  const Dependence on = dependence_of(measurement, force, top_mps);
  if (std::string fault = form_fault(on); !fault.empty()) return {std::nullopt, std::move(fault)};

  const bool over_velocity = !on.position && (on.speed || on.direction);
  const double lower = over_velocity ? -top_mps : travel.low;
  const double upper = over_velocity ? top_mps : travel.high;
  TabulatedEffect best;
  best.largest_error_N = HUGE_VAL;
  for (const bool by_direction : {false, true}) {
    if (!over_velocity && by_direction != on.direction) continue;
    const Profile profile(force, over_velocity, by_direction, 0.5 * (travel.low + travel.high), top_mps);
    const Fitted fitted = best_lines(profile, lower, upper, on.peak_N);
    if (fitted.largest_error_N < best.largest_error_N) best = table_of(profile, fitted, on.peak_N, top_mps);
    if (best.largest_error_N <= kLargestShare * on.peak_N) break;  // smooth through standstill
  }
  if (best.largest_error_N > std::max(kLargestShare * on.peak_N, allowed_N)) {
    return {std::nullopt, fmt::format("{} straight lines miss it by up to {:.3g} N of {:.3g} N", kIntervals,
                                      best.largest_error_N, on.peak_N)};
  }
  return {best, ""};
}

}  // namespace

Tabulated tabulate(const Measurement& measurement, const Term& term, double allowed_N) {
  UserForce force(term);
  try {
    return tabulate_form(measurement, force, allowed_N);
  } catch (const InputError&) {
    return {std::nullopt, "it is not a finite number everywhere between the places and speeds of this log"};
  }
}

}  // namespace slipstack::workbench
