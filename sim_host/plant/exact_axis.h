// SPDX-License-Identifier: Apache-2.0
// Forward dynamics without time-stepping error: mass, Maxwell elements, spring, damper, arm, sine force.
#pragma once

#include <array>
#include <cstddef>

#include "sim_host/plant/friction/maxwell_elements.h"

namespace slipstack::sim {

/// A force constant + amplitude·cos(ω·t + phase), t in absolute time.
struct SineForce {
  double constant_N = 0.0;
  double amplitude_N = 0.0;
  double rad_per_s = 0.0;
  double phase_rad = 0.0;
};

/// The linear part of an exact axis. The arm is a part of the mass on a spring, as in Resonance.
struct LinearPart {
  double mass_kg = 1.0;
  double viscous_N_s_per_m = 0.0;
  double spring_N_per_m = 0.0;
  double spring_rest_m = 0.0;
  double arm_ratio = 0.0;
  double arm_rad_per_s = 0.0;
  double arm_damping_ratio = 0.0;
};

/// The energy balance, J: work = kinetic + stored + dissipated − energy at the start.
struct EnergyAudit {
  double work = 0.0;
  double kinetic = 0.0;
  double stored = 0.0;
  double dissipated = 0.0;
  double imbalance() const { return work - kinetic - stored - dissipated; }
};

/// A mass on Maxwell elements, moved exactly.
///
/// Between events (a velocity reversal, an element that begins to slip, the instant asked for) the system is
/// linear with constant coefficients, and its solution is an entire function. It is summed as its power
/// series, over at most one radian of its fastest rate, where 22 terms reach rounding (1/22! = 1e-21); unlike
/// the form with sines it loses no digits when the stiffness becomes small in sliding. Events are roots of
/// these polynomials, found by safeguarded Newton steps. The result does not depend on the number of calls of
/// advance_to().
///
/// Cost: about 1 µs per event.
class ExactAxis {
 public:
  /// At rest at x with the bank relaxed there. Throws std::invalid_argument when the mass is not positive, a
  /// coefficient is negative, or the arm's share is not in [0, 1).
  ExactAxis(const LinearPart& linear, MaxwellElements bank, double x_m = 0.0);

  /// A new start; the state of `bank` is kept, and its position must be x.
  void restart(double t_s, MaxwellElements bank, double v_mps);
  void set_force(const SineForce& force) { force_ = force; }

  /// Advances to a later time through all events in between.
  void advance_to(double t_s);
  /// Advances to the next velocity reversal; false when there is none before t.
  bool advance_to_reversal(double t_s);

  double time_s() const { return t_s_; }
  double position_m() const { return bank_.position_m(); }
  double velocity_mps() const { return v_mps_; }
  double acceleration_mps2() const;
  double arm_m() const { return arm_m_; }
  const MaxwellElements& bank() const { return bank_; }
  /// Kinetic and stored energy now; work and losses since the start. One step per element.
  EnergyAudit energy() const;
  /// Energy in the system when it started, J.
  double initial_energy_J() const { return initial_J_; }
  std::size_t reversals() const { return reversals_; }
  std::size_t events() const { return events_; }

 private:
  static constexpr std::size_t kTerms = 22;
  using Series = std::array<double, kTerms>;
  // Displacement since the start of the interval between two events, velocity, acceleration, arm, as
  // functions of s = 0 … 1 over its length.
  struct Stretch {
    double length_s = 0.0;
    int direction = 0;
    Series u{}, v{}, a{}, q{}, w{};
  };
  enum class Event { kNone, kSlip, kReversal };

  Event stretch_to(double t_s);
  Stretch expand(double length_s, double stiffness) const;
  double longest_s(double stiffness, double left_s) const;
  int coming_direction() const;
  double net_force_N() const;
  double first_reversal(const Stretch& stretch) const;
  void commit(const Stretch& stretch, double s, Event event, double slip_at_m);
  void account(const Stretch& stretch, double s);
  double mechanical_energy_J() const;

  LinearPart linear_;
  double arm_kg_;
  double carriage_kg_;
  MaxwellElements bank_;
  SineForce force_;
  double t_s_ = 0.0;
  double v_mps_ = 0.0;
  double arm_m_ = 0.0;
  double arm_mps_ = 0.0;
  double work_J_ = 0.0;
  double viscous_J_ = 0.0;
  double bank_start_J_ = 0.0;
  double initial_J_ = 0.0;
  std::size_t reversals_ = 0;
  std::size_t events_ = 0;
};

}  // namespace slipstack::sim
