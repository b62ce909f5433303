// SPDX-License-Identifier: Apache-2.0
// The forces on the carriage at one instant, each by itself, for inverse and forward dynamics.
#pragma once

#include "sim_host/plant/axis.h"
#include "sim_host/plant/effects/effect_id.h"

namespace slipstack::sim {

/// States of the axis beside the carriage's position and velocity.
struct InnerState {
  double arm_m = 0.0;  // arm relative to carriage
  double arm_mps = 0.0;
  double level = 1.0;  // friction level after its lag
};

/// All forces at one instant, in N, positive when they resist positive motion; factors multiply the
/// hysteresis force one after the other.
struct Loads {
  double hysteresis_N = 0.0;
  double stribeck = 1.0;
  double lag = 1.0;
  double preload = 1.0;
  double asymmetry = 1.0;
  double drift = 1.0;
  double coulomb_N = 0.0;
  double viscous_N = 0.0;
  double viscous_asymmetry_N = 0.0;
  double viscous_drift_N = 0.0;
  double drag_N = 0.0;
  double ripple_N = 0.0;
  double offset_N = 0.0;
  double cable_N = 0.0;
  double outside_N = 0.0;
  double arm_N = 0.0;    // −m_arm·(ω²q + 2ζωq̇): the part of the arm's spring beside −m_arm·a
  double mass_kg = 0.0;  // of the carriage with its arm
  double arm_kg = 0.0;
  double payload_kg = 0.0;
  double motor_gain = 1.0;  // 1 + ripple of the motor constant

  double modulated_N() const { return hysteresis_N * stribeck * lag * preload * asymmetry * drift; }
  double rest_N() const {
    return coulomb_N + viscous_N + viscous_asymmetry_N + viscous_drift_N + drag_N + ripple_N + offset_N +
           cable_N + outside_N + arm_N;
  }
};

/// Forces of an axis on a carriage of `mass_kg` (the axis's, or the part of it behind a backlash). The
/// friction banks belong to the caller; only their forces are needed here.
Loads loads_on(const Axis& axis, double mass_kg, double t_s, double x_m, double v_mps, double hysteresis_N,
               double coulomb_N, const InnerState& inner);

/// Current × nominal motor constant that makes the carriage accelerate at `a_mps2` (inverse dynamics).
double drive_force_N(const Axis& axis, const Loads& loads, double a_mps2);

/// Acceleration under a given current × nominal motor constant (forward dynamics). Where the preload depends
/// on the acceleration, the equation is solved by Newton's method on a rising function; to rounding.
double acceleration_mps2(const Axis& axis, const Loads& loads, double drive_force_N);

/// Adds to `parts` the contribution of each effect to the drive force at acceleration a. The sum of the parts
/// equals drive_force_N to rounding. The part of a factor is its increase of the product of the factors
/// before it.
void add_parts(const Axis& axis, const Loads& loads, double a_mps2, PerEffect& parts);

/// Time derivatives of the inner states when the carriage moves with velocity v and acceleration a.
struct InnerRates {
  double arm_mps = 0.0;
  double arm_mps2 = 0.0;
  double level_per_s = 0.0;
};
InnerRates inner_rates(const Axis& axis, double v_mps, double a_mps2, const InnerState& inner);

}  // namespace slipstack::sim
