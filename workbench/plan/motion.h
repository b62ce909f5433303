// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {

/// What an axis may be asked for.
struct AxisLimits {
  double low_m = 0.0;
  double high_m = 0.0;
  double velocity_mps = 0.0;
  double acceleration_mps2 = 0.0;
  double jerk_mps3 = 0.0;
  double force_N = 0.0;  ///< 0: not limited
  double stroke_m() const { return high_m - low_m; }
};

/// Builds a motion piece by piece, every piece from where the last one ended, sampled at one rate. Velocity
/// and acceleration are continuous; the shapes are polynomials and cosines, their peaks known in closed form.
class MotionBuilder {
 public:
  MotionBuilder(double rate_Hz, double start_m);

  void dwell(double duration_s);
  /// From one velocity to another by 10u^3 - 15u^4 + 6u^5.
  void ramp(double from_mps, double to_mps, double duration_s);
  void hold(double velocity_mps, double duration_s);
  /// v (1 - depth (1 - cos 2 pi f t) / 2): slows down to (1 - depth) v and up again, each cycle.
  void wobble(double velocity_mps, double depth, double frequency_Hz, int cycles);
  /// A sine about where the axis stands, faded in over the first and out over the last cycle.
  void sine(double amplitude_m, double frequency_Hz, int cycles);
  /// Rest to rest by the quintic, as fast as the limits allow, slower by `pace` (at most 1).
  void move_to(double position_m, const AxisLimits& limits, double pace = 1.0);

  double position_m() const { return position_m_; }
  std::size_t size() const { return points_.size(); }
  const SetPoints& points() const { return points_; }

 private:
  struct State {
    double velocity_mps;
    double acceleration_mps2;
  };
  /// Appends `duration_s` of a motion given by velocity and acceleration over time.
  void append(double duration_s, const std::function<State(double)>& at);

  SetPoints points_;
  double position_m_;
};

/// Time that a ramp by `step_mps` takes within four fifths of the limits.
double ramp_time_s(double step_mps, const AxisLimits& limits);

/// Largest values of a motion; the jerk from differences of the acceleration.
AxisLimits extremes_of(const SetPoints& points);

}  // namespace slipstack::workbench
