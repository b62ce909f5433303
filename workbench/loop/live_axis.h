// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "workbench/model/term.h"
#include "workbench/simulate/set_points.h"

namespace slipstack::workbench {

/// What the name plates of motor, encoder and rail say: all that is known of an axis before it moves.
/// Positions are those that the drive reports.
struct Nameplate {
  double encoder_resolution_m = 0.0;
  double motor_constant_N_per_A = 0.0;
  double current_limit_A = 0.0;
  double travel_m = 0.0;  ///< 0: not known, the ends are to be searched
  double largest_velocity_mps = 0.0;
  std::optional<double> magnet_pitch_m;
  double tick_s = 1e-4;  ///< of the drive
  double low_m = 0.0;    ///< position of the lower end of the travel
  double largest_acceleration_mps2 = 15.0;

  double force_limit_N() const { return current_limit_A * motor_constant_N_per_A; }
};

/// What a drive is told of its axis beside the friction.
struct DriveSettings {
  double mass_kg = 1.0;  ///< what its estimate expects of a force
  double observer_rad_per_s = 400.0;
  double position_gain_per_s = 0.0;
  double velocity_gain_N_s_per_m = 0.0;
  double integral_per_s = 0.0;
  double force_limit_N = 0.0;
  double following_error_m = 5e-3;  ///< at which the drive stops
  // Beyond these the drive refuses a motion.
  double velocity_limit_mps = 1.0;
  double acceleration_limit_mps2 = 1.0;
  double jerk_limit_mps3 = 100.0;
};

/// What was recorded of a motion. A drive reports its command as the force.
struct AxisRecord {
  double rate_Hz = 0.0;
  std::vector<double> position_m;
  std::vector<double> force_N;
  std::vector<double> time_s;  ///< of each sample; empty where they are as far apart as rate_Hz says
  // Empty where the force was commanded.
  std::vector<double> reference_m;  ///< to a whole count
  std::vector<double> error_m;      ///< of it, less the drive's estimate of the position
  double limited_share = 0.0;       ///< of the time, at the limit of the force
  std::string fault;                ///< empty, or why the drive stopped; the record ends there
  bool lost_hold = false;           ///< the fault is that of an axis that left its reference, or stands
  bool limit_switch = false;        ///< the fault is a limit switch, or the end of the drive's own range
  // Of a pulse, where it differs from what was asked for; else 0.
  double pulse_s = 0.0;  ///< for how long the force pushed before it was turned round
  double pulse_N = 0.0;

  double duration_s() const { return static_cast<double>(position_m.size()) / rate_Hz; }
};

/// The drive does not answer, or not as it has to; what() says why, in one line.
struct DriveLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// An axis that can be moved, behind its drive. After a fault the axis is off. Every function that lets time
/// pass throws DriveLost.
class LiveAxis {
 public:
  virtual ~LiveAxis() = default;
  virtual const Nameplate& nameplate() const = 0;
  /// For how long the axis has been used, s.
  virtual double used_s() const = 0;
  /// Where the axis is held; where it stands while it is off.
  virtual double position_m() const = 0;

  /// The drive's own check by a push (firmware/control/supervision/direction_check.h), with half of the
  /// largest force at most. The axis is off afterwards.
  enum class Direction { kRight, kReversed, kBlocked };
  virtual Direction check_direction() = 0;
  /// Tells the drive, while it is off, that the motor is connected the other way round than it took it for
  /// before the commissioning.
  virtual void reverse_motor() = 0;

  /// This force for a time, then against it until the axis turns, or as long again; then off. Sampled in
  /// every tick.
  virtual AxisRecord pulse(double force_N, double seconds) = 0;

  /// Settings and model, both in the same tick; what ran before goes on until then. `target_terms`: as the
  /// controller runs them; empty: the mass alone. Empty text, or why the drive refused; it runs what it ran
  /// before then.
  virtual std::string deploy(const DriveSettings& settings, const Terms& target_terms) = 0;
  /// Enables the axis where it is off, and moves it along a motion that begins at position_m(), shifted by
  /// what that may have changed in enabling. Recorded at 2 kHz. Stays enabled.
  virtual AxisRecord run(const SetPoints& motion) = 0;
  virtual void switch_off() = 0;

  /// Keeps what was deployed last beyond the next power-on, and gives everything else that the commissioning
  /// changed back; the axis is off then. One line about it; empty: this axis keeps nothing.
  virtual std::string keep() { return ""; }
  /// Puts back what was in force before the commissioning began, where the axis outlives it. The axis is off.
  virtual void give_back() {}
};

}  // namespace slipstack::workbench
