// SPDX-License-Identifier: Apache-2.0
// Inverse dynamics: the drive force of a prescribed motion.
#pragma once

#include "sim_host/motion/programme.h"
#include "sim_host/plant/carriage.h"
#include "sim_host/plant/effects/effect_id.h"

namespace slipstack::sim {

/// An axis that follows a programme exactly. The friction is exact in displacement (reversals between two
/// instants are located on the closed-form motion to rounding); arm, lag and backlash are integrated by
/// fourth-order Runge-Kutta with steps of at most a tenth of their shortest time constant.
class PrescribedAxis {
 public:
  /// Starts relaxed at the programme's position at t = start. Keeps a reference to the programme.
  PrescribedAxis(const Axis& axis, const MotionProgramme& programme, double start_s = 0.0);

  /// Advances to a later time. Cost: one step per element that begins to slip, plus the Runge-Kutta steps.
  void advance_to(double t_s);

  double time_s() const { return t_s_; }
  /// Position of motor and encoder.
  MotionPoint motion() const { return programme_.at(t_s_); }
  /// Drive force (current × nominal motor constant) now, split into the contributions of the effects, N.
  PerEffect parts() const;
  const Carriage& carriage() const { return carriage_; }
  const InnerState& inner() const { return inner_; }

 private:
  struct State {
    double y_m, y_mps;  // carriage, where a backlash separates it from the motor
    InnerState inner;
  };
  State rates(double t_s, const State& state) const;
  void integrate(double step_s);
  double fastest_rate_per_s() const;
  bool has_inner_dynamics() const;

  Carriage carriage_;
  const MotionProgramme& programme_;
  double t_s_;
  InnerState inner_;
  double y_m_;
  double y_mps_ = 0.0;
};

}  // namespace slipstack::sim
