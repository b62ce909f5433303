// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>

#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// What an axis did in its logs: lower bounds of the magnitudes that it surely reached, never above them.
///
/// Positions and forces are means over a window; velocity, acceleration and jerk are differences of first to
/// third order of such means, divided by the powers of the window. A divided difference is the mean of the
/// derivative with a B-spline as weight, which is nowhere negative (Curry and Schoenberg 1966; de Boor, A
/// Practical Guide to Splines, 1978), so that it cannot exceed the largest value of the derivative. From each
/// its error is subtracted: five standard deviations of the noise and all that quantisation can do. Short
/// windows follow the motion, long ones suppress the noise; of windows of 1, 2, 4 ... 16 half periods of the
/// bandwidth of the force, the one with the largest bound counts.
struct MotionExtremes {
  double low_m = std::numeric_limits<double>::infinity();
  double high_m = -std::numeric_limits<double>::infinity();
  double velocity_mps = 0.0;
  double acceleration_mps2 = 0.0;
  double jerk_mps3 = 0.0;
  double force_N = 0.0;
  void add(const MotionExtremes& other);
  /// Includes the windows that begin at the samples [first, end) of a measurement. O(samples).
  void take(const Measurement& measurement, std::size_t first, std::size_t end);
};

}  // namespace slipstack::workbench
