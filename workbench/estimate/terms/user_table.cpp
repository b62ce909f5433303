// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/user_table.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "firmware/effects/user_table.h"
#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kIntervals = kUserTablePoints - 1;
constexpr double kLargestShare = 0.01;  ///< of the peak, that a table may miss
constexpr double kSame = 1e-9;          ///< of the peak: what counts as no difference
constexpr double kReversalShare =
    1.0 / 500;  ///< of the fastest motion: where the sign of velocity is a slope
constexpr std::size_t kGrid = 1U << 15;

/// The force of a fitted effect at any instant.
class UserForce {
 public:
  explicit UserForce(const Term& term) : term_(term), basis_(term.effect->make()) {
    basis_->prepare(term.shapes, {});
  }

  std::vector<double> at(const std::vector<Sample<double>>& samples) {
    const std::size_t gains = term_.gains_per_set();
    std::vector<double> columns(samples.size() * gains);
    basis_->run(samples, columns.data());
    std::vector<double> force_N(samples.size(), 0.0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      for (std::size_t g = 0; g < gains; ++g) force_N[i] += term_.gains[g] * columns[i * gains + g];
    }
    return force_N;
  }

 private:
  const Term& term_;
  std::unique_ptr<EffectBasis> basis_;
};

/// What a force depends on, found where the log was.
struct Dependence {
  bool time = false;
  bool acceleration = false;
  bool position = false;
  bool speed = false;
  bool direction = false;  ///< of velocity
  bool odd = true;         ///< it changes sign with velocity
  double peak_N = 0.0;
};

/// Instants of the log: where the force is largest, and throughout; none at standstill.
std::vector<Sample<double>> anchors_of(const Measurement& measurement, UserForce& force, double top_mps) {
  std::vector<Sample<double>> all;
  const std::size_t stride = std::max<std::size_t>(1, measurement.sample_count() / 20000);
  for (std::size_t i = 0; i < measurement.sample_count(); i += stride) {
    if (std::abs(measurement.velocity_mps()[i]) > 1e-6 * top_mps) all.push_back(measurement.sample(i));
  }
  const std::vector<double> force_N = force.at(all);
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t loud = std::min<std::size_t>(100, all.size());
  std::partial_sort(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(loud), order.end(),
      [&](std::size_t a, std::size_t b) { return std::abs(force_N[a]) > std::abs(force_N[b]); });
  std::vector<Sample<double>> anchors;
  for (std::size_t i = 0; i < loud; ++i) anchors.push_back(all[order[i]]);
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(1, all.size() / 200)) {
    anchors.push_back(all[i]);
  }
  return anchors;
}

Dependence dependence_of(const std::vector<Sample<double>>& anchors, UserForce& force) {
  Dependence on;
  const std::vector<double> here_N = force.at(anchors);
  for (const double value : here_N) on.peak_N = std::max(on.peak_N, std::abs(value));
  std::mt19937_64 random(20260211);
  // The force at every anchor with something of another anchor in its place.
  const auto with = [&](auto&& exchange) {
    std::vector<Sample<double>> moved = anchors;
    for (Sample<double>& sample : moved) exchange(sample, anchors[random() % anchors.size()]);
    return force.at(moved);
  };
  const auto differs = [&](const std::vector<double>& there_N) {
    for (std::size_t i = 0; i < here_N.size(); ++i) {
      if (std::abs(there_N[i] - here_N[i]) > kSame * on.peak_N) return true;
    }
    return false;
  };
  using S = Sample<double>;
  on.time = differs(with([](S& own, const S& other) { own.time_s = other.time_s; }));
  on.acceleration =
      differs(with([](S& own, const S& other) { own.acceleration_mps2 = other.acceleration_mps2; }));
  on.position = differs(with([](S& own, const S& other) { own.position_m = other.position_m; }));
  on.speed = differs(with([](S& own, const S& other) {
    own.velocity_mps = std::copysign(other.velocity_mps, own.velocity_mps);
  }));
  const std::vector<double> back_N = with([](S& own, const S&) { own.velocity_mps = -own.velocity_mps; });
  on.direction = differs(back_N);
  for (std::size_t i = 0; i < here_N.size(); ++i) {
    on.odd = on.odd && std::abs(back_N[i] + here_N[i]) <= kSame * on.peak_N;
  }
  return on;
}

/// The force along what the table follows, divided by the sign of velocity where the table multiplies it.
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
  // With a step at standstill, either side of it.
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

/// Straight lines through points at even places, the last value beyond either end.
struct Lines {
  double from = 0.0;
  double to = 1.0;
  std::array<double, kUserTablePoints> points{};

  /// The interval of a place and how far into it.
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

/// Points by least squares over even places of the window and some beyond it.
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
  const Eigen::VectorXd solved = normal.ldlt().solve(right);
  std::copy(solved.data(), solved.data() + kCount, lines.points.begin());
  return lines;
}

struct Fitted {
  Lines lines;
  double largest_error_N = HUGE_VAL;
};

/// The best of several windows: outside, the profile may be off its end values by more and more.
Fitted best_lines(const Profile& profile, double lower, double upper, double peak_N) {
  const std::vector<double> grid = evenly(lower, upper, kGrid + 1);
  const std::vector<double> values = profile.at(grid);
  Fitted best;
  for (const double share : {0.0, 1e-4, 3e-4, 1e-3, 2e-3, 4e-3, 7e-3}) {
    const double apart_N = std::max(share, kSame) * peak_N;
    std::size_t first = 0;
    std::size_t last = grid.size() - 1;
    while (first + 2 < grid.size() && std::abs(values[first + 1] - values.front()) <= apart_N) ++first;
    while (last > first + 1 && std::abs(values[last - 1] - values.back()) <= apart_N) --last;
    Fitted one{fitted_lines(profile, lower, upper, grid[first], grid[last]), 0.0};
    const auto judge = [&](const std::vector<double>& places, const std::vector<double>& is) {
      for (std::size_t i = 0; i < places.size(); ++i) {
        one.largest_error_N = std::max(one.largest_error_N, std::abs(one.lines.at(places[i]) - is[i]));
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

std::string form_fault(const Dependence& on) {
  if (on.time) return "it changes with time";
  if (on.acceleration) return "it follows acceleration";
  if (on.position && on.speed) return "it follows position and speed at once";
  if (on.position && on.direction && !on.odd) return "the directions differ in more than its sign";
  if (!(on.peak_N > 0.0)) return "it is zero wherever this log was";
  return "";
}

Tabulated tabulate_form(const Measurement& measurement, UserForce& force, double allowed_N) {
  const auto [lowest, highest] =
      std::minmax_element(measurement.position_m().begin(), measurement.position_m().end());
  double top_mps = 0.0;
  for (const double v : measurement.velocity_mps()) top_mps = std::max(top_mps, std::abs(v));
  if (!(top_mps > 0.0)) return {std::nullopt, "the log shows no motion"};
  const Dependence on = dependence_of(anchors_of(measurement, force, top_mps), force);
  if (std::string fault = form_fault(on); !fault.empty()) return {std::nullopt, std::move(fault)};

  const bool over_velocity = !on.position && (on.speed || on.direction);
  const double lower = over_velocity ? -top_mps : *lowest;
  const double upper = over_velocity ? top_mps : *highest;
  TabulatedEffect best;
  best.largest_error_N = HUGE_VAL;
  for (const bool by_direction : {false, true}) {
    if (!over_velocity && by_direction != on.direction) continue;
    const Profile profile(force, over_velocity, by_direction, 0.5 * (*lowest + *highest), top_mps);
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

Tabulated tabulate(const Measurement& measurement, const Term& own, double allowed_N) {
  UserForce force(own);
  try {
    return tabulate_form(measurement, force, allowed_N);
  } catch (const InputError&) {
    return {std::nullopt, "it is not a finite number everywhere between the places and speeds of this log"};
  }
}

}  // namespace slipstack::workbench
