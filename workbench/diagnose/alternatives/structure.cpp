// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "workbench/base/parallel.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/alternatives/reversals.h"
#include "workbench/diagnose/alternatives/spectral_line.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/signal/free_curve.h"

namespace slipstack::workbench {
namespace {

/// The distance of the knots around a value: a free curve shows no place better.
double resolution(const std::vector<double>& knots, double value) {
  if (knots.size() < 2) return 0.0;
  const std::size_t below = std::min(hat_weights(value, knots).below, knots.size() - 2);
  return knots[below + 1] - knots[below];
}

Structure over(Coordinate coordinate, const std::string& unit, const Eigen::VectorXd& values,
               const Eigen::VectorXd& residual, const Halves& halves) {
  const std::vector<double> knots = knots_over(values, kCurveIntervals);
  const Eigen::MatrixXd columns = hat_functions(values, knots);
  const HeldOut judged = held_out(columns, residual, halves);
  Eigen::Index peak = 0;
  judged.explained.cwiseAbs().maxCoeff(&peak);
  const double error_N = errors_of_sums(columns, residual, halves, columns.row(peak).transpose())(0);
  return {coordinate, judged.error_reduction, values(peak),
          fmt::format("what is left depends on {}: {} at {}", name_of(coordinate),
                      quantity_with_interval(judged.explained(peak), 2.0 * error_N, "N"),
                      quantity_with_interval(values(peak), resolution(knots, values(peak)), unit)),
          judged.explained};
}

/// A log, and the time from its beginning.
struct TimeInLog {
  std::size_t log = 0;
  double own_s = 0.0;
};

TimeInLog time_in_log(const Measurement& measurement, double time_s) {
  TimeInLog in{0, time_s};
  const auto length_s = [&] {
    return static_cast<double>(measurement.log_sample_count(in.log)) * measurement.tick_s();
  };
  for (; in.log + 1 < measurement.log_count() && in.own_s >= length_s(); ++in.log) in.own_s -= length_s();
  return in;
}

/// What a free curve over time tells of the residual.
Structure over_time(const Measurement& measurement, const Eigen::VectorXd& residual_N, const Halves& halves) {
  const Eigen::VectorXd times_s = row_times(measurement);
  Structure found = over(Coordinate::time, "s", times_s, residual_N, halves);
  if (measurement.log_count() > 1) {
    found.description += " (" + when_of(measurement, found.where, spread_of_moment_s(measurement)) + ")";
  }
  const double interval_s = resolution(knots_over(times_s, kCurveIntervals), found.where);
  found.description += note_at_start(measurement, found.where, interval_s);
  return found;
}

/// Energy concentrated in a few rows: an event, not an effect.
Structure event_in_time(const Measurement& measurement, const Eigen::VectorXd& residual) {
  const std::span<const double> rows(residual.data(), static_cast<std::size_t>(residual.size()));
  std::vector<double> energy;
  energy.reserve(rows.size());
  for (const double row : rows) energy.push_back(row * row);
  const double whole = std::accumulate(energy.begin(), energy.end(), 1e-300);
  const auto strongest = std::max_element(energy.begin(), energy.end()) - energy.begin();
  const auto few = static_cast<std::ptrdiff_t>(energy.size() / 100);
  std::nth_element(energy.begin(), energy.begin() + few, energy.end(), std::greater<>());
  const double share = std::accumulate(energy.begin(), energy.begin() + few, 0.0) / whole;
  // The strongest 1 % of Gaussian rows holds 8.6 % of the energy; of logs whose residual is quantisation at
  // reversals it holds about 30 %.
  constexpr double kUsual = 0.35;
  const double time_s = row_times(measurement)(strongest);
  const std::string when = when_of(measurement, time_s, spread_of_moment_s(measurement));
  return {Coordinate::time,
          reduction_beyond(share, kUsual),
          time_s,
          fmt::format(
              "what is left sits in few moments: 1 % of the time holds {:.0f} % of its square, most at {}",
              100.0 * share, when),
          residual,
          true};
}

}  // namespace

const char* name_of(Coordinate coordinate) {
  switch (coordinate) {
    case Coordinate::position:
      return "position";
    case Coordinate::velocity:
      return "velocity";
    case Coordinate::acceleration:
      return "acceleration";
    case Coordinate::time:
      return "time";
    case Coordinate::frequency:
      return "frequency";
    case Coordinate::reversal:
      return "reversal";
  }
  return "";
}

double spread_of_moment_s(const Measurement& measurement) {
  return 0.5 / measurement.bandwidth_Hz();
}

std::string when_of(const Measurement& measurement, double time_s, double half_width_s) {
  const auto [log, own_s] = time_in_log(measurement, time_s);
  std::string when = quantity_with_interval(own_s, half_width_s, "s");
  if (measurement.log_count() == 1) return when;
  const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
  return fmt::format("{} of {}", when, printable(part.path));
}

std::string note_at_start(const Measurement& measurement, double time_s, double half_width_s) {
  if (time_in_log(measurement, time_s).own_s > half_width_s) return "";
  return " (the log begins there, and nothing is known of the state that the friction has at its beginning)";
}

std::vector<Structure> find_structure(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const Halves halves = alternating_blocks(measurement);
  const auto over_motion = [&](Coordinate coordinate, const char* unit, const std::vector<double>& values) {
    return over(coordinate, unit, at_rows(measurement, values), residual_N, halves);
  };
  Structure line, position, velocity, acceleration, time, event, reversal;
  run_together(  // the longest first
      [&] { line = line_at_rows(measurement, residual_N); },
      [&] { time = over_time(measurement, residual_N, halves); },
      [&] { position = over_motion(Coordinate::position, "m", measurement.position_m()); },
      [&] { velocity = over_motion(Coordinate::velocity, "m/s", measurement.velocity_mps()); },
      [&] { acceleration = over_motion(Coordinate::acceleration, "m/s2", measurement.acceleration_mps2()); },
      [&] { event = event_in_time(measurement, residual_N); },
      [&] { reversal = after_reversals(measurement, residual_N); });
  // Moments that recur at reversals do not depend on time.
  if (reversal.error_reduction < kMajority * event.error_reduction &&
      event.error_reduction > time.error_reduction)
    time = std::move(event);
  std::vector<Structure> found{std::move(position), std::move(velocity), std::move(acceleration),
                               std::move(time),     std::move(line),     std::move(reversal)};
  // Without a line, or moments after reversals, there is nothing to be told of them.
  std::erase_if(found, [](const Structure& one) { return one.description.empty(); });
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.error_reduction > b.error_reduction; });
  return found;
}

}  // namespace slipstack::workbench
