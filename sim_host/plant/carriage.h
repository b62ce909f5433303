// SPDX-License-Identifier: Apache-2.0
// The guided body with its friction: the part that forward and inverse dynamics share.
#pragma once

#include "sim_host/plant/axis.h"
#include "sim_host/plant/friction/maxwell_elements.h"
#include "sim_host/plant/loads.h"

namespace slipstack::sim {

/// The carriage: friction with its history, and the forces at any trial state.
class Carriage {
 public:
  /// Throws std::invalid_argument when a mass, a level, a length or a share is not physical.
  explicit Carriage(const Axis& axis);

  const Axis& axis() const { return axis_; }
  /// Mass of the guided body: the whole, or the part behind the backlash.
  double mass_kg() const { return mass_kg_; }
  /// Mass on the motor's side of the backlash; 0 without one.
  double motor_mass_kg() const { return axis_.mass_kg - mass_kg_; }

  /// Forces after a move to x without reversal, at velocity v there; changes nothing.
  Loads loads_after(double t_s, double x_m, double v_mps, const InnerState& inner) const;
  /// Moves the friction there; the caller splits a motion at its reversals.
  void move_to(double x_m);
  void reset(double x_m);
  /// The payload from now on, kg. Throws as the constructor does.
  void carry(double payload_kg);

  const MaxwellElements& hysteresis() const { return hysteresis_; }
  const MaxwellElements& coulomb() const { return coulomb_; }
  /// Largest tangent stiffness, N/m: sets the fastest motion of the carriage on its friction.
  double largest_stiffness_N_per_m() const;

 private:
  Axis axis_;
  double mass_kg_;
  MaxwellElements hysteresis_;
  MaxwellElements coulomb_;
};

/// Force that the motor's side exerts on the carriage across the gap, N: motor − carriage in position and
/// speed.
double contact_force_N(const Backlash& backlash, double carriage_kg, double gap_m, double gap_mps);

}  // namespace slipstack::sim
