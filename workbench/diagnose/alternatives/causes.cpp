// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/causes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/tangent.h"

namespace slipstack::workbench {
namespace {

/// A fitted cause in its model, with what the intervals of its values are made from.
class DescribedCause {
 public:
  DescribedCause(const Measurement& measurement, const FittedModel& model, const Term& cause)
      : measurement_(measurement), model_(model), cause_(cause) {
    for (const Term& term : model.terms) {
      if (term.effect == cause.effect) break;
      first_ += static_cast<Eigen::Index>(term.gains.size());
      ++index_;
    }
  }

  const Measurement& measurement() const { return measurement_; }
  const Term& term() const { return cause_; }
  /// Of the cause, at the rows.
  Eigen::MatrixXd columns() const { return model_.linearisation->columns_of(cause_); }

  /// Standard errors of the first shapes, which are moved by `steps` for their derivatives, and then of sums
  /// of the cause's gains, one in each column; all unknowns of the model jointly.
  Eigen::VectorXd errors(const std::vector<double>& steps, const Eigen::MatrixXd& gain_sums) const {
    const Eigen::MatrixXd& known = model_.linearisation->columns();
    const Eigen::Index gains = known.cols();
    const auto shapes = static_cast<Eigen::Index>(steps.size());
    Eigen::MatrixXd columns(known.rows(), gains + shapes);
    columns.leftCols(gains) = known;
    NormalEquations::Constraints constraints = model_.constraints;
    constraints.lower.conservativeResize(gains + shapes);
    constraints.upper.conservativeResize(gains + shapes);
    constraints.penalty.conservativeResizeLike(Eigen::MatrixXd::Zero(gains + shapes, gains + shapes));
    BoundedSolution solution = model_.solution;
    solution.value.conservativeResizeLike(Eigen::VectorXd::Zero(gains + shapes));
    solution.bound_states.resize(static_cast<std::size_t>(gains + shapes), BoundState::free);
    for (Eigen::Index i = 0; i < shapes; ++i) {
      const auto shape = static_cast<std::size_t>(i);
      columns.col(gains + i) = derivative_by_shape(measurement_, model_, {index_, shape, steps[shape]});
      constraints.lower(gains + i) = -static_cast<double>(kUnbounded);
      constraints.upper(gains + i) = static_cast<double>(kUnbounded);
    }
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(gains + shapes, gain_sums.cols());
    sums.middleRows(first_, gain_sums.rows()) = gain_sums;
    const NormalEquations equations(measurement_, columns, model_.linearisation->target());
    return equations.standard_errors(solution, constraints, sums).tail(shapes + sums.cols());
  }

  /// How far the time of a change may be off, 95 % to either side: the distribution of the time at which a
  /// regression changes most (Bai 1997, Estimation of a change point in multiple regression models, section
  /// IV). The variance is that of the mean residual, from the sums within blocks.
  double time_half_width_s() const {
    const Eigen::VectorXd& weights = measurement_.fit_weights();
    const Eigen::VectorXd weighted = weights.cwiseProduct(model_.linearisation->residual_N());
    double variance = 0.0;
    for (const RowRange& range : block_ranges(measurement_))
      variance += std::pow(weighted.segment(range.first, range.count).sum(), 2);
    variance /= std::max(weights.squaredNorm(), 1e-300);
    const Eigen::VectorXd change_N =
        columns() * Eigen::Map<const Eigen::VectorXd>(cause_.gains.data(),
                                                      static_cast<Eigen::Index>(cause_.gains.size()));
    const double after = (change_N.array() != 0.0).cast<double>().sum();
    const double squared_change = change_N.squaredNorm() / std::max(after, 1.0);
    // Quantile of 97.5 % for equal variances, in units of variance over squared change (Bai 1997, section
    // IV).
    constexpr double kQuantileOfChange = 11.03;
    const double rows = kQuantileOfChange * variance / std::max(squared_change, 1e-300) + 1.0;
    return rows * static_cast<double>(measurement_.row_stride()) * measurement_.tick_s();
  }

 private:
  const Measurement& measurement_;
  const FittedModel& model_;
  const Term& cause_;
  Eigen::Index first_ = 0;
  std::size_t index_ = 0;
};

/// "+12.0 +- 1.3 %": two standard errors to either side.
std::string change_with_interval(double share, double error) {
  return (share < 0.0 ? "" : "+") +
         (error > 0.0 ? number_with_interval(100.0 * share, 200.0 * error)
                      : fmt::format("{:.3g}", 100.0 * share)) +
         " %";
}

/// " and is as before from 14.70 +- 0.12 s on"; empty where the change lasts to the end of the log.
std::string until_text(const DescribedCause& cause) {
  const Measurement& measurement = cause.measurement();
  const double until_s = cause.term().shapes[1];
  if (until_s >= measurement.sample(measurement.sample_count() - 1).time_s) return "";
  return fmt::format(" and is as before from {} on",
                     quantity_with_interval(until_s, cause.time_half_width_s(), "s"));
}

/// Those of two statements that the log determines; both where it determines neither.
std::string determined_of(bool first, const std::string& of_first, const char* between, bool second,
                          const std::string& of_second) {
  if (first == second) return of_first + between + of_second;
  return first ? of_first : of_second;
}

void describe_change(const DescribedCause& cause, Structure& structure) {
  const Term& term = cause.term();
  const Eigen::VectorXd errors = cause.errors({}, Eigen::MatrixXd::Identity(2, 2));
  const bool level = std::abs(term.gains[0]) > 2.0 * errors(0);
  const bool offset = std::abs(term.gains[1]) > 2.0 * errors(1);
  structure.determined = level || offset;
  structure.description = fmt::format(
      "the friction changes at {}{}: {}",
      when_of(cause.measurement(), term.shapes[0], cause.time_half_width_s()), until_text(cause),
      determined_of(
          level, fmt::format("its level by {}", change_with_interval(term.gains[0], errors(0))), ", ", offset,
          fmt::format("the offset by {}", quantity_with_interval(term.gains[1], 2.0 * errors(1), "N"))));
}

std::string load_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  const Eigen::VectorXd errors = cause.errors({}, Eigen::MatrixXd::Identity(1, 1));
  return fmt::format("the {} changes at {}{}, by {}, as where a payload is {}", mass_word(),
                     when_of(cause.measurement(), term.shapes[0], cause.time_half_width_s()),
                     until_text(cause), quantity_with_interval(term.gains[0], 2.0 * errors(0), "kg"),
                     term.gains[0] > 0.0 ? "picked up" : "put down");
}

/// A step of a shape for its derivative, far below the scale on which the force is curved.
constexpr double kSmallStep = 1e-2;

/// A place that is known neither within its width nor in its width is none.
void describe_place(const DescribedCause& cause, Structure& structure) {
  const Term& term = cause.term();
  const double half_width_m = term.shapes[1];
  const double force_N = std::hypot(term.gains[0], term.gains[1]);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(3, 2);
  sums.col(0).head(2) = Eigen::Vector2d(term.gains[0], term.gains[1]) / std::max(force_N, 1e-300);
  sums(2, 1) = 1.0;
  const double step_m = kSmallStep * half_width_m;
  const Eigen::VectorXd errors = cause.errors({step_m, step_m}, sums);
  const bool force = force_N > 2.0 * errors(2);
  const bool friction = std::abs(term.gains[2]) > 2.0 * errors(3);
  structure.determined = half_width_m > 2.0 * std::min(errors(0), errors(1)) && (force || friction);
  structure.description = fmt::format(
      "a {} sits at one {}, {}, within {} to either side: {}", force_word(),
      axis_is_rotary() ? "angle" : "place of the rail",
      quantity_with_interval(term.shapes[0], 2.0 * errors(0), "m"),
      quantity_with_interval(half_width_m, 2.0 * errors(1), "m"),
      determined_of(force, quantity_with_interval(force_N, 2.0 * errors(2), "N"), ", and ", friction,
                    fmt::format("the friction is {} there", change_with_interval(term.gains[2], errors(3)))));
}

std::string line_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  double amplitude_N = 0.0;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(term.gains.size()), 1);
  for (std::size_t i = 0; i + 1 < term.gains.size(); i += 2) {
    const double own_N = std::hypot(term.gains[i], term.gains[i + 1]);
    if (own_N <= amplitude_N) continue;
    amplitude_N = own_N;
    sum.setZero();
    sum.middleRows(static_cast<Eigen::Index>(i), 2) =
        Eigen::Vector2d(term.gains[i], term.gains[i + 1]) / own_N;
  }
  // A small part of a period over the whole log.
  const double step_Hz = kSmallStep / cause.measurement().duration_s();
  const Eigen::VectorXd errors = cause.errors({step_Hz}, sum);
  return fmt::format("the {} has a line in time at {}, amplitude {}, whatever the motion", force_word(),
                     quantity_with_interval(term.shapes[0], 2.0 * errors(0), "Hz"),
                     quantity_with_interval(amplitude_N, 2.0 * errors(1), "N"));
}

/// Where the mass is least and where it is largest, among places over the travel.
void describe_mass_over_position(const DescribedCause& cause, Structure& structure) {
  constexpr int kPlacesOfMass = 40;  // ten in half a period of the shortest harmonic
  const Term& term = cause.term();
  const auto harmonics_at = [](int place) {
    Eigen::VectorXd harmonics(kMassHarmonics);
    for (int k = 1; k <= kMassHarmonics; ++k)
      harmonics(k - 1) = std::cos(k * std::numbers::pi * place / kPlacesOfMass);
    return harmonics;
  };
  const Eigen::Map<const Eigen::VectorXd> gains(term.gains.data(), kMassHarmonics);
  int least = 0;
  int most = 0;
  for (int place = 1; place <= kPlacesOfMass; ++place) {
    const double mass = gains.dot(harmonics_at(place));
    if (mass < gains.dot(harmonics_at(least))) least = place;
    if (mass > gains.dot(harmonics_at(most))) most = place;
  }
  const auto position_m = [&](int place) {
    return term.shapes[0] + (term.shapes[1] - term.shapes[0]) * place / kPlacesOfMass;
  };
  const Eigen::VectorXd rise = harmonics_at(most) - harmonics_at(least);
  const double rise_kg = gains.dot(rise);
  const double error_kg = cause.errors({}, rise)(0);
  structure.where = position_m(most);
  structure.determined = rise_kg > 2.0 * error_kg;
  structure.description = fmt::format(
      "the {} depends on the {}: least at {}, more by {} at {} (a link, a crank or a mass that "
      "moves with the axis)",
      mass_word(), axis_is_rotary() ? "angle" : "position", quantity(position_m(least), "m"),
      quantity_with_interval(rise_kg, 2.0 * error_kg, "kg"), quantity(position_m(most), "m"));
}

void describe_viscous_over_time(const DescribedCause& cause, Structure& structure) {
  const Term& term = cause.term();
  const double change = term.gains[0] + term.gains[1] + term.gains[2];  // each is one at the end of the log
  const double error = cause.errors({}, Eigen::Vector3d::Ones())(0);
  structure.where = term.shapes[1];
  structure.determined = std::abs(change) > 2.0 * error;
  structure.description = fmt::format(
      "the viscous friction changes during the log, by {} from its start to its end (the lubricant warms)",
      quantity_with_interval(change, 2.0 * error, "N s/m"));
}

/// The relative error of the values of a gap that its form causes: flanks are elastic, and friction is more
/// than one stop operator. Width and mass found on twelve simulated axes, of which a form without these was
/// fitted, scatter by a quarter about the true ones (docs/theory.md).
constexpr double kErrorOfGap = 0.25;

std::string gap_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  const std::vector<double> steps{kSmallStep * term.shapes[0]};
  const Eigen::VectorXd errors = cause.errors(steps, Eigen::MatrixXd::Identity(1, 1));
  const auto with_interval = [](double value, double error, const char* unit) {
    return quantity_with_interval(value, 2.0 * std::hypot(error, kErrorOfGap * value), unit);
  };
  return fmt::format(
      "the drive has a gap of {}: a part of {} behind it runs free whenever the {} on it changes its sign, "
      "and "
      "then meets the other side (backlash or a loose coupling)",
      with_interval(term.shapes[0], errors(0), "m"), with_interval(term.gains[0], errors(1), "kg"),
      force_word());
}

std::string deflection_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  const Eigen::VectorXd errors = cause.errors({kSmallStep * term.shapes[0]}, Eigen::MatrixXd::Identity(1, 1));
  return fmt::format(
      "after each reversal, until it slips, the friction also grows with the velocity, by {} in {}: damping "
      "of "
      "the contacts (sigma1 of the LuGre model)",
      quantity_with_interval(term.gains[0] / term.shapes[0], 2.0 * errors(1) / term.shapes[0], "N s/m"),
      quantity_with_interval(term.shapes[0], 2.0 * errors(0), "m"));
}

std::string bristle_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  const Eigen::VectorXd errors = cause.errors({kSmallStep * term.shapes[0]}, Eigen::MatrixXd::Identity(1, 1));
  const bool determined = term.gains[0] > 2.0 * errors(1);
  return fmt::format(
      "{}the friction{} is that of a bristle (Dahl, LuGre, Bouc-Wen) with a slip distance of {}: it "
      "forgets a turning point as soon as the axis turns back, which the hysteresis of the catalogue "
      "remembers",
      determined ? "" : "most of ",
      determined ? fmt::format(", {} of it,", quantity_with_interval(term.gains[0], 2.0 * errors(1), "N"))
                 : "",
      quantity_with_interval(term.shapes[0], 2.0 * errors(0), "m"));
}

/// The time between two knots of a force over time, and the time of one.
double knot_distance_s(const Term& term) {
  return (term.shapes[1] - term.shapes[0]) / kCurveIntervals;
}
double knot_s(const Term& term, std::ptrdiff_t knot) {
  return term.shapes[0] + knot_distance_s(term) * static_cast<double>(knot);
}

/// The knots at which a curve over time is lowest and highest, among those that the log determines: in the
/// first and the last interval there may be hardly any rows, and the curve is anywhere there. Their errors
/// are far above the usual one.
struct KnotsOfCurve {
  std::ptrdiff_t lowest = 0;
  std::ptrdiff_t highest = 0;
};
KnotsOfCurve extreme_knots(const DescribedCause& cause) {
  const std::vector<double>& value_N = cause.term().gains;
  const auto count = static_cast<Eigen::Index>(value_N.size());
  const Eigen::VectorXd errors_N = cause.errors({}, Eigen::MatrixXd::Identity(count, count));
  // Times the median error: a knot that is known less well is none of the extremes. Chosen.
  constexpr double kKnownKnot = 4.0;
  const double most_N = kKnownKnot * median({errors_N.begin(), errors_N.end()});
  KnotsOfCurve extreme{-1, -1};
  for (std::ptrdiff_t knot = 0; knot < std::ssize(value_N); ++knot) {
    if (errors_N(knot) > most_N) continue;
    const double own_N = value_N[static_cast<std::size_t>(knot)];
    if (extreme.lowest < 0 || own_N < value_N[static_cast<std::size_t>(extreme.lowest)])
      extreme.lowest = knot;
    if (extreme.highest < 0 || own_N > value_N[static_cast<std::size_t>(extreme.highest)]) {
      extreme.highest = knot;
    }
  }
  return extreme;
}

void describe_curve(const DescribedCause& cause, const KnotsOfCurve& extreme, Structure& structure) {
  const Term& term = cause.term();
  Eigen::MatrixXd rise = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(term.gains.size()), 1);
  rise(extreme.highest, 0) += 1.0;
  rise(extreme.lowest, 0) -= 1.0;
  const double rise_N = rise.col(0).dot(
      Eigen::Map<const Eigen::VectorXd>(term.gains.data(), static_cast<Eigen::Index>(term.gains.size())));
  const double error_N = cause.errors({}, rise)(0);
  structure.determined = rise_N > 2.0 * error_N;
  const auto at = [&](std::ptrdiff_t knot) {  // a free curve shows no time better than its knots lie
    return quantity_with_interval(knot_s(term, knot), knot_distance_s(term), "s");
  };
  structure.description = fmt::format(
      "the {} depends on time, whatever the motion: lowest at {}, higher by {} at {}", force_word(),
      at(extreme.lowest), quantity_with_interval(rise_N, 2.0 * error_N, "N"), at(extreme.highest));
}

std::string after_reversals_text(const DescribedCause& cause) {
  const Term& term = cause.term();
  const Eigen::MatrixXd columns = cause.columns();
  const Eigen::VectorXd force_N =
      columns * Eigen::Map<const Eigen::VectorXd>(term.gains.data(), columns.cols());
  // Where the rows have hardly any weight, the force is anything.
  Eigen::Index most = 0;
  force_N.cwiseAbs2().cwiseProduct(cause.measurement().fit_weights()).maxCoeff(&most);
  const double error_N = cause.errors({}, columns.row(most).transpose())(0);
  // More than the whole force is one that other terms take back.
  const double size_N = std::abs(force_N(most));
  const bool determined =
      size_N > 2.0 * error_N && size_N < cause.measurement().force_N().cwiseAbs().maxCoeff();
  return fmt::format(
      "whenever the load of the drive changes its sign the {} differs for {}{} (backlash or a loose "
      "coupling; "
      "a filter of the {} or friction of another form looks alike)",
      force_word(), quantity(term.shapes[0], "s"),
      determined ? fmt::format(", by up to {} below {}", quantity_with_interval(size_N, 2.0 * error_N, "N"),
                               quantity(cause.measurement().bandwidth_Hz(), "Hz"))
                 : "",
      force_word());
}

/// Amplitude of two harmonics (rms times sqrt 2) with its standard error, behind that of the pitch.
struct Repetition {
  double pitch_error_m = 0.0;
  double amplitude = 0.0;
  double amplitude_error = 0.0;
};
Repetition repetition_of(const DescribedCause& cause) {
  const Term& term = cause.term();
  const Eigen::Map<const Eigen::VectorXd> gains(term.gains.data(),
                                                static_cast<Eigen::Index>(term.gains.size()));
  const double amplitude = gains.norm();
  const Eigen::VectorXd errors =
      cause.errors({1e-3 * kSmallStep * term.shapes[0]}, gains / std::max(amplitude, 1e-300));
  return {errors(0), amplitude, errors(1)};
}

std::string second_ripple_text(const DescribedCause& cause) {
  const Repetition found = repetition_of(cause);
  return fmt::format(
      "the {} repeats over the position with a second pitch, {}, amplitude {} "
      "(the catalogue's ripple has one pitch; the other can be an effect of your own)",
      force_word(), quantity_with_interval(cause.term().shapes[0], 2.0 * found.pitch_error_m, "m"),
      quantity_with_interval(found.amplitude, 2.0 * found.amplitude_error, "N") +
          (found.amplitude < 2.0 * found.amplitude_error ? ", not determined" : ""));
}

std::string friction_ripple_text(const DescribedCause& cause) {
  const Repetition found = repetition_of(cause);
  return fmt::format(
      "the friction repeats over the position every {}, by {} % of its level "
      "(a screw, balls or a bearing with a preload that varies), which is too short for a map",
      quantity_with_interval(cause.term().shapes[0], 2.0 * found.pitch_error_m, "m"),
      number_with_interval(100.0 * found.amplitude, 200.0 * found.amplitude_error));
}

void describe_power_of_velocity(const DescribedCause& cause, Structure& structure) {
  const Term& term = cause.term();
  const Eigen::VectorXd errors = cause.errors({kSmallStep * term.shapes[0]}, Eigen::MatrixXd::Identity(1, 1));
  structure.where = term.shapes[1];
  structure.determined = std::abs(term.gains[0]) > 2.0 * errors(1);
  structure.description = fmt::format(
      "a part of the friction grows with a power of the velocity, {}, to {} at {} (the lubricant thins in "
      "shear)",
      number_with_interval(term.shapes[0], 2.0 * errors(0)),
      quantity_with_interval(term.gains[0], 2.0 * errors(1), "N"), quantity(term.shapes[1], "m/s"));
}

/// Coordinate, place and text of a fitted cause.
Structure place_and_text(const DescribedCause& described) {
  const Term& cause = described.term();
  Structure structure;
  structure.where = cause.shapes[0];
  switch (form_of(*cause.effect)) {
    case CauseForm::line_in_time:
      structure.coordinate = Coordinate::frequency;
      structure.description = line_text(described);
      break;
    case CauseForm::change_at_a_time:
      structure.coordinate = Coordinate::time;
      describe_change(described, structure);
      break;
    case CauseForm::load_from_a_time:
      structure.coordinate = Coordinate::time;
      structure.description = load_text(described);
      break;
    case CauseForm::force_at_a_place:
      structure.coordinate = Coordinate::position;
      describe_place(described, structure);
      break;
    case CauseForm::gap_in_drive:
      structure.coordinate = Coordinate::reversal;
      structure.description = gap_text(described);
      break;
    case CauseForm::damped_deflection:
      structure.coordinate = Coordinate::reversal;
      structure.description = deflection_text(described);
      break;
    case CauseForm::bristle:
      structure.coordinate = Coordinate::reversal;
      structure.description = bristle_text(described);
      break;
    case CauseForm::after_load_reversals:
      structure.coordinate = Coordinate::reversal;
      structure.description = after_reversals_text(described);
      break;
    case CauseForm::second_ripple:
      structure.coordinate = Coordinate::position;
      structure.description = second_ripple_text(described);
      break;
    case CauseForm::friction_ripple:
      structure.coordinate = Coordinate::position;
      structure.description = friction_ripple_text(described);
      break;
    case CauseForm::mass_over_position:
      structure.coordinate = Coordinate::position;
      describe_mass_over_position(described, structure);
      break;
    case CauseForm::viscous_over_time:
      structure.coordinate = Coordinate::time;
      describe_viscous_over_time(described, structure);
      break;
    case CauseForm::power_of_velocity:
      structure.coordinate = Coordinate::velocity;
      describe_power_of_velocity(described, structure);
      break;
    case CauseForm::force_over_time: {
      structure.coordinate = Coordinate::time;
      structure.free_curve = true;
      const KnotsOfCurve extreme = extreme_knots(described);
      structure.where = knot_s(cause, extreme.highest);
      describe_curve(described, extreme, structure);
      const double earlier_s = knot_s(cause, std::min(extreme.lowest, extreme.highest));
      structure.description += note_at_start(described.measurement(), earlier_s, knot_distance_s(cause));
      break;
    }
  }
  return structure;
}

bool is_change_in_time(const EffectDescription& cause) {
  return form_of(cause) == CauseForm::change_at_a_time || form_of(cause) == CauseForm::load_from_a_time;
}

}  // namespace

Structure described_cause(const Measurement& measurement, const FittedModel& model, const Term& cause,
                          double without_N) {
  Structure structure = place_and_text(DescribedCause(measurement, model, cause));
  structure.error_reduction = 1.0 - model.holdout_rmse_N / std::max(without_N, 1e-300);
  // Two breaks anywhere fit whatever differs between two parts of a log.
  if (is_change_in_time(*cause.effect) &&
      !explains_most(without_N, model.holdout_rmse_N, measurement.noise_floor_N())) {
    structure.determined = false;
  }
  structure.form_of_friction = cause.effect->acts_as(Acts::dry);
  structure.explained_N =
      model.linearisation->columns_of(cause) *
      Eigen::Map<const Eigen::VectorXd>(cause.gains.data(), static_cast<Eigen::Index>(cause.gains.size()));
  return structure;
}

void tell_together(std::vector<Structure>& causes, const std::vector<std::string>& beside, double holdout_N) {
  const auto rank = [](const Structure& one) {
    const bool is_strong_force = !one.form_of_friction && explains_most(1.0, 1.0 - one.error_reduction, 0.0);
    return std::pair(is_strong_force, one.error_reduction);
  };
  std::sort(causes.begin(), causes.end(),
            [&](const Structure& a, const Structure& b) { return rank(a) > rank(b); });
  std::string& told = causes.front().description;
  for (std::size_t i = 1; i < causes.size(); ++i) {
    if (causes[i].determined) told += "; besides, " + causes[i].description;
  }
  const std::string others = fmt::format("{}", fmt::join(beside, ", "));
  std::string with = causes.size() == 1 ? "it" : "all that was chosen";
  if (!others.empty()) with += causes.size() == 1 ? " and " + others : " (also " + others + ")";
  told += fmt::format("; with {} the held-out error is {}", with, quantity(holdout_N, "N"));
}

}  // namespace slipstack::workbench
