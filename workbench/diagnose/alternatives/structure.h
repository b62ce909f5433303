// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What a free curve over one coordinate finds in a residual: no physics, only "something depends on this".
struct Structure {
  std::string coordinate;        ///< position, velocity, acceleration, time, frequency, reversal
  double error_reduction = 0.0;  ///< of the residual's rms, on held-out rows
  double where = 0.0;            ///< of the largest departure, in the coordinate's unit
  std::string description;       ///< one sentence
  Eigen::VectorXd explained_N;   ///< what the curve says, at the rows
};

/// Looks for structure in `residual_N` (rows) along every coordinate, the strongest first.
std::vector<Structure> find_structure(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// A time, and of several logs which.
std::string when_of(const Measurement& measurement, double time_s);

}  // namespace slipstack::workbench
