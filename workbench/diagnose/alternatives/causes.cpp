// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "workbench/base/quantity.h"

namespace slipstack::workbench {
namespace {

std::string change_text(const Measurement& measurement, const Term& term) {
  return fmt::format("the friction changes at {}: its level by {:+.3g} %, the offset by {}",
                     when_of(measurement, term.shapes[0]), 100.0 * term.gains[0],
                     quantity(term.gains[1], "N"));
}

std::string place_text(const Term& term) {
  return fmt::format(
      "a force sits at one place of the rail, {}, within {} to either side: {}, and the friction is "
      "{:+.3g} % there",
      quantity(term.shapes[0], "m"), quantity(term.shapes[1], "m"),
      quantity(std::hypot(term.gains[0], term.gains[1]), "N"), 100.0 * term.gains[2]);
}

std::string line_text(const Term& term) {
  double amplitude_N = 0.0;
  for (std::size_t i = 0; i + 1 < term.gains.size(); i += 2)
    amplitude_N = std::max(amplitude_N, std::hypot(term.gains[i], term.gains[i + 1]));
  return fmt::format("the force has a line in time at {}, amplitude {}, whatever the motion",
                     quantity(term.shapes[0], "Hz"), quantity(amplitude_N, "N"));
}

/// The time of a knot of a force over time.
double knot_s(const Term& term, std::ptrdiff_t knot) {
  return term.shapes[0] + (term.shapes[1] - term.shapes[0]) * static_cast<double>(knot) / kCurveIntervals;
}

std::string curve_text(const Term& term) {
  const auto [low, high] = std::minmax_element(term.gains.begin(), term.gains.end());
  return fmt::format("the force depends on time, whatever the motion: lowest at {}, higher by {} at {}",
                     quantity(knot_s(term, low - term.gains.begin()), "s"), quantity(*high - *low, "N"),
                     quantity(knot_s(term, high - term.gains.begin()), "s"));
}

/// Coordinate, place and text of a fitted cause.
Structure place_and_text(const Measurement& measurement, const Term& cause) {
  Structure structure;
  structure.where = cause.shapes[0];
  switch (form_of(*cause.effect)) {
    case CauseForm::line_in_time:
      structure.coordinate = Coordinate::frequency;
      structure.description = line_text(cause);
      break;
    case CauseForm::change_at_a_time:
      structure.coordinate = Coordinate::time;
      structure.description = change_text(measurement, cause);
      break;
    case CauseForm::force_at_a_place:
      structure.coordinate = Coordinate::position;
      structure.description = place_text(cause);
      break;
    case CauseForm::force_over_time: {
      structure.coordinate = Coordinate::time;
      const auto high = std::max_element(cause.gains.begin(), cause.gains.end());
      structure.where = knot_s(cause, high - cause.gains.begin());
      structure.description = curve_text(cause);
      break;
    }
  }
  return structure;
}

}  // namespace

Structure described_cause(const Measurement& measurement, const FittedModel& model, const Term& cause,
                          double without_N) {
  Structure structure = place_and_text(measurement, cause);
  structure.error_reduction = 1.0 - model.holdout_rmse_N / std::max(without_N, 1e-300);
  structure.description +=
      fmt::format("; with it the held-out error is {}", quantity(model.holdout_rmse_N, "N"));
  structure.explained_N =
      model.linearisation->columns_of(cause) *
      Eigen::Map<const Eigen::VectorXd>(cause.gains.data(), static_cast<Eigen::Index>(cause.gains.size()));
  return structure;
}

}  // namespace slipstack::workbench
