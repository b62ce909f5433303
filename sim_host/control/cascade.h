// SPDX-License-Identifier: Apache-2.0
// The drive's own controller, as it is before friction is compensated.
#pragma once

#include "sim_host/motion/segment.h"
#include "sim_host/plant/axis.h"

namespace slipstack::sim {

/// Position P, velocity PI, mass feed-forward, force limit with the integrator stopped at it.
class CascadeController {
 public:
  struct Gains {
    double position_per_s = 50.0;
    double velocity_N_s_per_m = 1000.0;
    double integral_per_s = 50.0;
    double velocity_filter_rad_per_s = 1000.0;
    double feedforward_kg = 0.0;
    double limit_N = 1e300;
  };

  CascadeController(const Gains& gains, double period_s, double position_m);

  /// Gains for a velocity loop of the given bandwidth on the nominal mass: position and integral at a quarter
  /// of it, velocity filter at four times. The bandwidth is lowered where one encoder count through the
  /// velocity loop would be more than a third of the friction: with a higher bandwidth the encoder's steps
  /// dominate the force.
  static Gains tuned(const Axis& axis, double bandwidth_Hz);

  /// Force command for the next period, N, from the reference and the encoder's position.
  double update_N(const MotionPoint& reference, double measured_m);

 private:
  Gains gains_;
  double period_s_;
  double filter_;  // share of the new value
  double last_m_;
  double velocity_mps_ = 0.0;
  double integral_N_ = 0.0;
};

}  // namespace slipstack::sim
