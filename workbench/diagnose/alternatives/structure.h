// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What a residual can depend on.
enum class Coordinate { position, velocity, acceleration, time, frequency, reversal };
const char* name_of(Coordinate coordinate);

/// A dependence that is found in a residual without a physical model: a free curve over one coordinate, a
/// line in the spectrum, an event, or what follows reversals.
struct Structure {
  Coordinate coordinate = Coordinate::position;
  double error_reduction = 0.0;  ///< of the residual's rms, on held-out rows
  /// Of the largest deviation, in the unit of the coordinate; of a reversal its time, or the way of its
  /// cause.
  double where = 0.0;
  std::string description;        ///< a sentence without its capital and its full stop
  Eigen::VectorXd explained_N;    ///< the part of the residual that the structure explains, at the rows
  bool only_where = false;        ///< it tells when the residual is large, and no force
  bool free_curve = false;        ///< it is one of many values, without a form of its own
  bool determined = true;         ///< by the log: a value is larger than its interval, a change explains most
  bool form_of_friction = false;  ///< it takes the place of the hysteresis, and adds no force
};

/// Searches `residual_N` (rows) for structure along every coordinate: one for each, the strongest first.
std::vector<Structure> find_structure(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// The time as text, with its interval where one is given; with several logs, the time within its log and the
/// name of the log.
std::string when_of(const Measurement& measurement, double time_s, double half_width_s = 0.0);

/// What is to be said of a time whose interval begins with its log: the friction has a state there that no
/// model knows, until the axis has moved far enough to forget it. Empty for a later time.
std::string note_at_start(const Measurement& measurement, double time_s, double half_width_s);

/// How far the filter of the rows spreads a moment to either side [s]: half a period of the bandwidth.
double spread_of_moment_s(const Measurement& measurement);

}  // namespace slipstack::workbench
