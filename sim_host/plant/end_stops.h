// SPDX-License-Identifier: Apache-2.0
// Mechanical stops at the ends of an axis: springs with damping, one-sided.
#pragma once

#include <algorithm>

namespace slipstack::sim {

struct EndStops {
  double negative_m = 0.0;
  double positive_m = 0.0;
  double stiffness_N_per_m = 1e6;  ///< elastomer of some millimetres before steel
  double damping_N_s_per_m = 3e3;

  /// On the carriage; pushes only.
  double force_N(double position_m, double velocity_mps) const {
    if (position_m < negative_m) {
      return std::max(0.0, stiffness_N_per_m * (negative_m - position_m) - damping_N_s_per_m * velocity_mps);
    }
    if (position_m > positive_m) {
      return std::min(0.0, stiffness_N_per_m * (positive_m - position_m) - damping_N_s_per_m * velocity_mps);
    }
    return 0.0;
  }
};

}  // namespace slipstack::sim
