// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "workbench/model/term.h"

namespace slipstack::workbench {

/// A commanded motion of an axis, sampled uniformly from time 0.
struct SetPoints {
  double rate_Hz = 1000.0;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  std::vector<double> acceleration_mps2;

  std::size_t size() const { return position_m.size(); }
  double duration_s() const { return static_cast<double>(size()) / rate_Hz; }
};

/// A motion as CSV text: `# key: value` lines, then time_s,position_m,velocity_mps,acceleration_mps2.
std::string to_csv(const SetPoints& points, const std::vector<std::string>& header);

/// A motion of at least three positions; velocity and acceleration, where they are empty, by central
/// differences.
SetPoints complete(SetPoints points);

/// The force that a model predicts along a motion; hysteresis relaxed at its start.
std::vector<double> force_along(const SetPoints& points, const Terms& terms);

}  // namespace slipstack::workbench
