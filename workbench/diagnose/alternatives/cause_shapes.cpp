// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/causes.h"
#include "workbench/diagnose/alternatives/spectral_line.h"
#include "workbench/diagnose/detectability/separation.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/nonlinear/trial.h"

namespace slipstack::workbench {
namespace {

/// A time behind the last sample.
double end_of_log_s(const Measurement& measurement) {
  return measurement.sample(measurement.sample_count() - 1).time_s + measurement.tick_s();
}

/// Sums over rows for a regression of a residual on columns.
template <int kColumns>
struct RegressionSums {
  using Columns = Eigen::Matrix<double, kColumns, 1>;
  Eigen::Matrix<double, kColumns, kColumns> gram = Eigen::Matrix<double, kColumns, kColumns>::Zero();
  Columns right = Columns::Zero();

  RegressionSums plus(const Columns& column, double residual_N, double weight) const {
    return {gram + weight * column * column.transpose(), right + weight * residual_N * column};
  }
  RegressionSums operator-(const RegressionSums& other) const {
    return {gram - other.gram, right - other.right};
  }
  /// The sum of squares that the regression explains. Columns that are nothing here, compared with the
  /// `whole` log, are left out: an axis that stands has no acceleration but what rounding leaves.
  double explained(const RegressionSums& whole) const {
    const Columns least = 1e-9 * whole.gram.diagonal();
    const Columns scale = (gram.diagonal().array() > least.array())
                              .select(gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), 0.0);
    Eigen::Matrix<double, kColumns, kColumns> scaled = scale.asDiagonal() * gram * scale.asDiagonal();
    scaled.diagonal().array() += 1e-9;
    const Columns target = scale.cwiseProduct(right);
    return target.dot(scaled.ldlt().solve(target));
  }
};

/// Sums over the rows before each row, and over all.
template <int kColumns>
using SumsUntil = std::vector<RegressionSums<kColumns>>;

/// What a regression of its own within rows [from, until) and another outside them explain.
template <int kColumns>
double explained_apart(const SumsUntil<kColumns>& sums, std::size_t from, std::size_t until) {
  const RegressionSums<kColumns> inside = sums[until] - sums[from];
  return inside.explained(sums.back()) + (sums.back() - inside).explained(sums.back());
}

/// The row from which on, to the end of the log, that is most; 0 where there is none.
template <int kColumns>
std::size_t best_break(const SumsUntil<kColumns>& sums) {
  const std::size_t end = sums.size() - 1;
  double most = 0.0;
  std::size_t best = 0;
  for (std::size_t row = 1; row < end; ++row) {
    const double explained = explained_apart(sums, row, end);
    if (explained <= most) continue;
    most = explained;
    best = row;
  }
  return best;
}

/// Rows [from, until) within the log for which that is most: on a grid, then each end by itself. Two breaks
/// (Bai and Perron 1998) with the same regression before the first and after the second.
template <int kColumns>
std::pair<std::size_t, std::size_t> best_interval(const SumsUntil<kColumns>& sums) {
  // Steps of the first search: half a second of a log of one minute. Chosen.
  constexpr std::size_t kGrid = 128;
  const std::size_t end = sums.size() - 1;
  const std::size_t step = std::max<std::size_t>(1, end / kGrid);
  std::pair<std::size_t, std::size_t> best{0, 0};
  double most = 0.0;
  const auto take = [&](std::size_t from, std::size_t until) {
    const double explained = explained_apart(sums, from, until);
    if (explained <= most) return;
    most = explained;
    best = {from, until};
  };
  for (std::size_t from = step; from + step < end; from += step) {
    for (std::size_t until = from + step; until < end; until += step) take(from, until);
  }
  for (bool again = most > 0.0; again;) {
    const auto [from, until] = best;
    for (std::size_t row = std::max(step, from) - step; row < std::min(from + step, until); ++row)
      take(row, until);
    for (std::size_t row = std::max(until - step, best.first + 1); row < std::min(until + step, end); ++row)
      take(best.first, row);
    again = best.first != from && best.second != until;
  }
  return best;
}

/// The time from which on a regression of its own, on the columns of a row, explains most of the residual (a
/// structural break; Chow 1960, Quandt 1960), and until when: to the end of the log, unless an interval
/// leaves an error that is smaller by what is worth a name.
template <int kColumns, class ColumnsOfRow>
std::optional<std::vector<double>> time_of_break(const Measurement& measurement, const FittedModel& model,
                                                 ColumnsOfRow&& columns_of) {
  const Eigen::VectorXd residual_N = model.linearisation->residual_N();
  const Eigen::VectorXd& weights = measurement.fit_weights();
  SumsUntil<kColumns> sums(static_cast<std::size_t>(residual_N.size()) + 1);
  double squares_N2 = 0.0;
  for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
    sums[static_cast<std::size_t>(row) + 1] =
        sums[static_cast<std::size_t>(row)].plus(columns_of(row), residual_N(row), weights(row));
    squares_N2 += weights(row) * squared(residual_N(row));
  }
  const std::size_t end = sums.size() - 1;
  const std::size_t from = best_break(sums);
  if (from == 0) return {};
  const auto time_s = [&](std::size_t row) {
    return measurement.sample(measurement.row_samples()[row]).time_s;
  };
  const auto interval = best_interval(sums);
  const auto left_N = [&](double explained_N2) {
    return std::sqrt(std::max(0.0, squares_N2 - explained_N2));
  };
  if (interval.second > interval.first &&
      is_worth_a_name(left_N(explained_apart(sums, from, end)),
                      left_N(explained_apart(sums, interval.first, interval.second)))) {
    return std::vector{time_s(interval.first), time_s(interval.second)};
  }
  return std::vector{time_s(from), end_of_log_s(measurement)};
}

/// Of friction and offset.
std::optional<std::vector<double>> time_of_change(const Measurement& measurement, const FittedModel& model) {
  const Eigen::VectorXd dry_N = at_rows(measurement, model.linearisation->sample_dry_N());
  return time_of_break<2>(measurement, model,
                          [&](Eigen::Index row) { return Eigen::Vector2d(dry_N(row), 1.0); });
}

/// Of the mass.
std::optional<std::vector<double>> time_of_load(const Measurement& measurement, const FittedModel& model) {
  const Eigen::VectorXd acceleration_mps2 = at_rows(measurement, measurement.acceleration_mps2());
  return time_of_break<1>(measurement, model, [&](Eigen::Index row) {
    return Eigen::Matrix<double, 1, 1>(acceleration_mps2(row));
  });
}

/// The residual over the position, rows in the order of the position.
class Rail {
 public:
  Rail(const Measurement& measurement, const FittedModel& model)
      : position_m_(at_rows(measurement, measurement.position_m())),
        dry_N_(at_rows(measurement, model.linearisation->sample_dry_N())),
        residual_N_(model.linearisation->residual_N()),
        weights_(measurement.fit_weights()),
        order_(static_cast<std::size_t>(position_m_.size())) {
    std::iota(order_.begin(), order_.end(), Eigen::Index{0});
    std::sort(order_.begin(), order_.end(),
              [this](Eigen::Index a, Eigen::Index b) { return position_m_(a) < position_m_(b); });
    const Eigen::VectorXd weighted_N = weights_.cwiseProduct(dry_N_);
    level_gram_ = weighted_N.dot(dry_N_);
    level_right_ = weighted_N.dot(residual_N_);
  }

  double first_m() const { return position_m_(order_.front()); }
  double travel_m() const { return position_m_(order_.back()) - first_m(); }
  /// How far the axis moves from row to row, in the mean.
  double resolution_m() const {
    const Eigen::Index steps = position_m_.size() - 1;
    return (position_m_.tail(steps) - position_m_.head(steps)).cwiseAbs().mean();
  }

  /// The sum of squares that a force within `half_width_m` of `middle_m` explains, beside a change of the
  /// friction everywhere: the model has its level from where the axis is most of the time.
  /// `symmetric`: a force that is strongest in the middle.
  double explained(double middle_m, double half_width_m, bool symmetric = false) const {
    Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    gram(3, 3) = level_gram_;
    right(3) = level_right_;
    for (auto row = from(middle_m - half_width_m);
         row != order_.end() && position_m_(*row) < middle_m + half_width_m; ++row) {
      auto columns = place_basis((position_m_(*row) - middle_m) / half_width_m);
      columns[2] *= dry_N_(*row);
      if (symmetric) columns[1] = 0.0;
      const Eigen::Map<const Eigen::Vector3d> column(columns.data());
      const Eigen::Vector3d weighted = weights_(*row) * column;
      gram.topLeftCorner<3, 3>().noalias() += weighted * column.transpose();
      gram.topRightCorner<3, 1>() += dry_N_(*row) * weighted;
      right.head<3>() += residual_N_(*row) * weighted;
    }
    gram.bottomLeftCorner<1, 3>() = gram.topRightCorner<3, 1>().transpose();
    // Scaled to a unit diagonal: forces and the dry friction have other sizes.
    const Eigen::Vector4d scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    gram.diagonal().array() += 1e-9;
    right = scale.cwiseProduct(right);
    return right.dot(gram.ldlt().solve(right));
  }

 private:
  std::vector<Eigen::Index>::const_iterator from(double low_m) const {
    return std::lower_bound(order_.begin(), order_.end(), low_m,
                            [this](Eigen::Index row, double value) { return position_m_(row) < value; });
  }

  Eigen::VectorXd position_m_;
  Eigen::VectorXd dry_N_;
  Eigen::VectorXd residual_N_;
  Eigen::VectorXd weights_;
  double level_gram_ = 0.0;
  double level_right_ = 0.0;
  std::vector<Eigen::Index> order_;
};

/// The longest slip distance of the model's hysteresis; 0 without one.
double longest_slip_m(const Terms& terms) {
  const Term* hysteresis = find_role(terms, Role::hysteresis);
  if (hysteresis == nullptr) return 0.0;
  double longest = 0.0;
  for (std::size_t i = 0; i < hysteresis->gains.size(); ++i) {
    if (hysteresis->gains[i] > 0.0)
      longest = std::max(longest, hysteresis->shapes[i % hysteresis->gains_per_set()]);
  }
  return longest;
}

std::optional<std::vector<double>> place_and_width(const Measurement& measurement, const FittedModel& model) {
  const Rail rail(measurement, model);
  const double travel_m = rail.travel_m();
  // Within the pre-sliding travel a force over the place is the form of the hysteresis.
  const double least_m = std::max(rail.resolution_m(), longest_slip_m(model.terms));
  const double most_m = kWidestPlace * travel_m;
  if (!(travel_m > 0.0) || least_m >= most_m) return {};
  const auto best_place = [&](bool symmetric) {
    double most = 0.0;
    std::vector<double> best;
    for (double half_width_m = most_m; half_width_m >= least_m; half_width_m *= 0.5) {
      for (double middle_m = rail.first_m(); middle_m <= rail.first_m() + travel_m;
           middle_m += 0.5 * half_width_m) {
        const double explained = rail.explained(middle_m, half_width_m, symmetric);
        if (explained <= most) continue;
        most = explained;
        best = {middle_m, half_width_m};
      }
    }
    if (best.empty()) return best;
    const std::vector<ShapeRange> ranges{{0, best[0] - best[1], best[0] + best[1], false, 0.25 * best[1]},
                                         {1, least_m, most_m, true}};
    return refine_shapes(
               ranges, best,
               [&](const std::vector<double>& at) { return -rail.explained(at[0], at[1], symmetric); },
               SearchEffort{})
        .shapes;
  };
  const std::vector<double> any = best_place(false);
  if (any.empty()) return {};
  // Of a force that is strongest in the middle the place is that of its peak. Beside it a slope would move
  // the middle of a wider window away.
  const std::vector<double> peak = best_place(true);
  const bool is_peak =
      !peak.empty() && rail.explained(peak[0], peak[1], true) > kMajority * rail.explained(any[0], any[1]);
  return is_peak ? peak : any;
}

/// The shapes of least error, of model and cause fitted jointly: from `starts`, or near others that are
/// known.
std::vector<double> best_of(const Measurement& measurement, const FittedModel& model,
                            const EffectDescription& cause, std::vector<std::vector<double>> starts,
                            const std::vector<ShapeRange>& ranges, const std::vector<double>* near,
                            const SearchEffort& effort) {
  if (near != nullptr) {
    starts = {*near};
    for (const ShapeRange& range : ranges) {
      double& shape = starts.front()[range.index];
      shape = std::clamp(shape, range.lower, range.upper);
    }
  }
  return jointly_best_shapes(measurement, model, cause, starts, ranges, effort);
}

/// Of the strongest line in the residual, then of model and line jointly: what the model explains of a line
/// is missing in its residual. Within a period over the log to either side there is no other minimum.
std::optional<std::vector<double>> frequency_of_line(const Measurement& measurement, const FittedModel& model,
                                                     const EffectDescription& cause) {
  // To the minimum: with a first look the frequency was off by two half widths (docs/theory.md).
  constexpr SearchEffort kToTheEnd{60, 1e-9};
  const Structure strongest = line_at_rows(measurement, weighted_residual(measurement, model));
  if (!(strongest.where > 0.0)) return {};
  const double period_Hz = 1.0 / measurement.longest_log_s();
  const ShapeRange range{0, std::max(0.5 * strongest.where, strongest.where - period_Hz),
                         strongest.where + period_Hz, false, 0.1 * period_Hz};
  return jointly_best_shapes(measurement, model, cause, {{strongest.where}}, {range}, kToTheEnd);
}

/// What decelerates the whole axis: its friction by its mass. 0 without either.
double deceleration_of_axis_mps2(const FittedModel& model) {
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  const double mass = mass_kg(model.terms);
  return hysteresis != nullptr && mass > 0.0 ? hysteresis_level_N(*hysteresis, 0) / mass : 0.0;
}

/// Where the deceleration of a carriage that is a part of the axis is searched; the second shape of a cause.
ShapeRange deceleration_range(double whole_mps2) {
  return {1, 0.5 * whole_mps2, 10.0 * whole_mps2, true};
}

/// Width of the gap, deceleration by the friction behind it, and slip distance of that friction. A shorter
/// gap than the longest slip distance is another form of the hysteresis.
std::optional<std::vector<double>> gap_and_friction(const Measurement& measurement, const FittedModel& model,
                                                    const EffectDescription& cause,
                                                    const std::vector<double>* near,
                                                    const SearchEffort& effort) {
  // The friction of the whole axis slows down no more than its whole mass, and often less.
  const double least_mps2 = deceleration_of_axis_mps2(model);
  const double longest_m = longest_slip_m(model.terms);
  const double least_m = std::max(measurement.encoder_resolution_m(), longest_m);
  const double most_m = kWidestPlace * measurement.position_range_m().length();
  if (!(least_mps2 > 0.0) || least_m >= most_m) return {};
  const double slip_m = mean_slip_m(*find_role(model.terms, Role::hysteresis));
  std::vector<std::vector<double>> starts;
  for (double gap_m = least_m; gap_m < most_m; gap_m *= 2.0) {
    for (const double share : {1.0, 0.5}) starts.push_back({gap_m, least_mps2 / share, slip_m});
  }
  return best_of(
      measurement, model, cause, std::move(starts),
      {{0, least_m, most_m, true}, deceleration_range(least_mps2), {2, 0.1 * slip_m, longest_m, true}}, near,
      effort);
}

/// The distance within which the deflection of a bristle develops that has the hysteresis of the model: half
/// its mean slip distance where the virgin curve is an exponential (its elements then have a level in
/// proportion to s exp(-s / distance)). 0 without a hysteresis.
double distance_as_bristle_m(const FittedModel& model) {
  const Term* hysteresis = find_role(model.terms, Role::hysteresis);
  return hysteresis == nullptr ? 0.0 : 0.5 * mean_slip_m(*hysteresis);
}

/// The distance within which the deflection develops is that of the hysteresis, with which it is one bristle,
/// to a factor of two for curves that are no exponential. Within less than ten encoder steps none is seen (as
/// of velocities, search_ranges.cpp).
std::optional<std::vector<double>> distance_of_deflection(const Measurement& measurement,
                                                          const FittedModel& model,
                                                          const EffectDescription& cause,
                                                          const std::vector<double>* near,
                                                          const SearchEffort& effort) {
  const double distance_m = distance_as_bristle_m(model);
  const ShapeRange range{0, 0.5 * distance_m, 2.0 * distance_m, true};
  if (!(range.lower > 10.0 * measurement.encoder_resolution_m()) || !(distance_m > 0.0)) return {};
  return best_of(measurement, model, cause, {{distance_m}}, {range}, near, effort);
}

/// The distance within which the deflection of a bristle that replaces the hysteresis develops: as above, to
/// a factor of four. Within a few encoder steps no loop is seen, and a bristle is Coulomb friction.
std::optional<std::vector<double>> distance_of_bristle(const Measurement& measurement,
                                                       const FittedModel& model,
                                                       const EffectDescription& cause,
                                                       const std::vector<double>* near,
                                                       const SearchEffort& effort) {
  const double distance_m = distance_as_bristle_m(model);
  const ShapeRange range{0, std::max(0.25 * distance_m, 4.0 * measurement.encoder_resolution_m()),
                         4.0 * distance_m, true};
  if (!(range.lower < range.upper)) return {};
  const double start_m = std::max(distance_m, range.lower);
  return best_of(measurement, model, cause, {{start_m}, {0.5 * (start_m + range.upper)}}, {range}, near,
                 effort);
}

/// The time after a load reversal within which the force differs, and the friction that decides when the load
/// changes its sign: that of the whole axis by its whole mass, or of a carriage that is a part of it. The
/// knots lie half a period of the bandwidth apart, closer they are not told apart, or up to four times that,
/// but beyond the first no longer than a blow lasts.
std::optional<std::vector<double>> window_and_friction(const Measurement& measurement,
                                                       const FittedModel& model,
                                                       const EffectDescription& cause,
                                                       const std::vector<double>* near,
                                                       const SearchEffort& effort) {
  const double whole_mps2 = deceleration_of_axis_mps2(model);
  if (!(whole_mps2 > 0.0)) return {};
  const double slip_m = mean_slip_m(*find_role(model.terms, Role::hysteresis));
  const double least_s = kKnotsAfterReversal / (2.0 * measurement.bandwidth_Hz());
  const double most_s = std::max(least_s, std::min(4.0 * least_s, longest_blow_s(measurement)));
  std::vector<std::vector<double>> starts;
  for (const double wider : {1.0, 2.0, 4.0}) {
    const double window_s = std::min(wider * least_s, most_s);
    for (const double share : {1.0, 0.5}) starts.push_back({window_s, whole_mps2 / share, slip_m});
  }
  std::vector<ShapeRange> ranges{deceleration_range(whole_mps2)};
  if (most_s > least_s) ranges.push_back({0, least_s, most_s, true});
  return best_of(measurement, model, cause, std::move(starts), ranges, near, effort);
}

/// The exponent, and the largest speed of the log.
std::optional<std::vector<double>> exponent_and_speed(const Measurement& measurement,
                                                      const FittedModel& model,
                                                      const EffectDescription& cause,
                                                      const std::vector<double>* near,
                                                      const SearchEffort& effort) {
  const ValueRange velocity_mps = value_range(measurement.velocity_mps());
  const double speed_mps = std::max(-velocity_mps.low, velocity_mps.high);
  return best_of(measurement, model, cause, {{0.5, speed_mps}}, {{0, kLeastExponent, kMostExponent, false}},
                 near, effort);
}

/// The work on shapes that were found beside other effects.
constexpr SearchEffort kAgain{kFirstLook.evaluations / 2, kFirstLook.tolerance};

}  // namespace

std::optional<std::vector<double>> shapes_of_cause(const Measurement& measurement, const FittedModel& model,
                                                   const EffectDescription& cause,
                                                   const std::vector<double>* near,
                                                   const SearchEffort& effort) {
  switch (form_of(cause)) {
    case CauseForm::line_in_time:
      return frequency_of_line(measurement, model, cause);
    case CauseForm::change_at_a_time:
      return time_of_change(measurement, model);
    case CauseForm::load_from_a_time:
      return time_of_load(measurement, model);
    case CauseForm::force_at_a_place:
      return place_and_width(measurement, model);
    case CauseForm::gap_in_drive:
      return gap_and_friction(measurement, model, cause, near, effort);
    case CauseForm::damped_deflection:
      return distance_of_deflection(measurement, model, cause, near, effort);
    case CauseForm::bristle:
      return distance_of_bristle(measurement, model, cause, near, effort);
    case CauseForm::after_load_reversals:
      return window_and_friction(measurement, model, cause, near, effort);
    case CauseForm::second_ripple:
    case CauseForm::friction_ripple:
      return {};  // is_searched_as_effect()
    case CauseForm::mass_over_position: {
      const ValueRange travelled = measurement.position_range_m();
      return std::vector{travelled.low, travelled.high};
    }
    case CauseForm::power_of_velocity:
      return exponent_and_speed(measurement, model, cause, near, effort);
    case CauseForm::viscous_over_time: {
      const std::vector<std::size_t>& rows = measurement.row_samples();
      return std::vector{measurement.sample(rows.front()).time_s, measurement.sample(rows.back()).time_s};
    }
    case CauseForm::force_over_time:
      break;
  }
  return std::vector{measurement.sample(0).time_s, measurement.sample(measurement.sample_count() - 1).time_s};
}

FittedModel with_causes_found_again(const Measurement& measurement, FittedModel model) {
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const EffectDescription& cause = *model.terms[i].effect;
    if (!is_outside_catalogue(cause)) continue;
    const FittedModel others = fit_gains(measurement, without(model.terms, cause.text.id), &model);
    const auto shapes = shapes_of_cause(measurement, others, cause, &model.terms[i].shapes, kAgain);
    if (!shapes || *shapes == model.terms[i].shapes) continue;
    Terms moved = model.terms;
    moved[i].shapes = *shapes;
    FittedModel again = fit_gains(measurement, std::move(moved), &others);
    if (again.train_rmse_N < model.train_rmse_N) model = std::move(again);
  }
  return model;
}

}  // namespace slipstack::workbench
