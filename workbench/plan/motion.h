// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {

/// The limits of a commanded motion.
struct AxisLimits {
  double low_m = 0.0;
  double high_m = 0.0;
  double velocity_mps = 0.0;
  double acceleration_mps2 = 0.0;
  double jerk_mps3 = 0.0;
  double force_N = 0.0;  ///< 0: not limited
  /// Whether the force is that of the log: then it limits that of the log's model, else that of the model
  /// with the effects that are planned for.
  bool force_of_log = false;
  double stroke_m() const { return high_m - low_m; }
};

/// Builds a motion step by step, each from the position where the last one ended, sampled at one rate.
/// Velocity and acceleration are continuous; they are polynomials and cosines, whose peaks are known in
/// closed form.
class MotionBuilder {
 public:
  MotionBuilder(double rate_Hz, double start_m);

  void dwell(double duration_s);
  /// From one velocity to another by 10u^3 - 15u^4 + 6u^5.
  void ramp(double from_mps, double to_mps, double duration_s);
  void hold(double velocity_mps, double duration_s);
  /// v (1 - depth (1 - cos 2 pi f t) / 2): the velocity falls to (1 - depth) v and rises again in each cycle.
  void wobble(double velocity_mps, double depth, double frequency_Hz, int cycles);
  /// A sine about the present position, its amplitude rising over the first cycle and falling over the last.
  void sine(double amplitude_m, double frequency_Hz, int cycles);
  /// From standstill to standstill by a quintic polynomial, as fast as the limits allow times `pace` (at most
  /// 1).
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

/// Duration of a ramp by `step_mps` within four fifths of the limits.
double ramp_time_s(double step_mps, const AxisLimits& limits);

/// Largest values of a motion; the jerk by differences of the acceleration.
AxisLimits extremes_of(const SetPoints& points);

}  // namespace slipstack::workbench
