// SPDX-License-Identifier: Apache-2.0
// Forward dynamics on smooth virgin curves, with every effect, by Runge-Kutta steps that end at events.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "sim_host/plant/carriage.h"
#include "sim_host/plant/exact_axis.h"
#include "sim_host/plant/friction/masing.h"

namespace slipstack::sim {

/// Whether nothing acts beside mass, payload and pre-sliding hysteresis, and the current follows at once.
bool has_mass_and_hysteresis_only(const Axis& axis);

/// The axis under a force given as a function of time.
///
/// Dormand and Prince's pair of orders 5 and 4 (J. Comput. Appl. Math. 6, 1980) with step-size control. Steps
/// end where the carriage reverses or an inner loop closes (found by Newton steps on the step length), so
/// that between events everything is smooth and the order is kept. The friction is the virgin curve itself,
/// not elements: with finer and finer elements ExactAxis converges to this.
///
/// Effects of the axis act as in Plant, the drive's current limit and loop included; the encoder and the
/// recording delay are the caller's. A Coulomb seal (an element that slips after nanometres) is left to step
/// control.
///
/// Cost: 0.15 µs per step with mass and hysteresis only, some 15 to 40 steps per swing at 1e-8.
class SmoothAxis {
 public:
  struct Options {
    double tolerance = 1e-8;    // local error over the size of the motion
    double fixed_step_s = 0.0;  // > 0: steps of this length, no control; for showing the order
  };

  /// At rest and relaxed at x. Throws std::invalid_argument on an unphysical axis.
  SmoothAxis(const Axis& axis, double x_m);
  SmoothAxis(const Axis& axis, double x_m, const Options& options);

  /// Moves the carriage there quasi-statically and holds it: the friction keeps its history, the arm is at
  /// rest.
  void place(double x_m);
  /// The command of the drive (current × motor constant), from now on; its time counts from now. The
  /// integrals start again at zero.
  void set_force(const SineForce& force);
  /// Advances to a time through all events; time counts from the construction.
  void advance_to(double t_s);
  /// Advances to the next velocity reversal; false when there is none before t.
  bool advance_to_reversal(double t_s);

  double time_s() const { return t_s_; }
  double position_m() const { return y_[kX]; }
  double velocity_mps() const { return y_[kV]; }
  double hysteresis_N() const { return masing_.force_N(y_[kX]); }
  /// Largest and smallest position since set_force, by events and step ends, m.
  double highest_m() const { return highest_m_; }
  double lowest_m() const { return lowest_m_; }
  /// ∫(x − x₀)·exp(−iωt) dt since the last clear_integrals(), x₀ the position then, t since set_force; m·s.
  /// Only under a force with a frequency.
  std::complex<double> integral() const { return {y_[kCos], -y_[kSin]}; }
  /// ∫(x − x₀) dt since then, m·s.
  double mean_integral() const { return y_[kMean]; }
  double integral_origin_m() const { return x_ref_m_; }
  void clear_integrals();

  std::size_t steps() const { return steps_; }
  std::size_t reversals() const { return reversals_; }
  const Masing& hysteresis() const { return masing_; }

  /// The whole state as numbers, and back: a run that is continued gives the same result bit for bit.
  std::vector<double> snapshot() const;
  void restore(const std::vector<double>& values);

 private:
  enum : std::size_t { kX, kV, kCos, kSin, kMean, kArm, kArmSpeed, kLevel, kDrive, kStates };
  using State = std::array<double, kStates>;
  enum class Event { kNone, kReversal, kClosure };
  struct Step {
    State end;
    State rate;  // at its end
    double error;
  };

  template <std::size_t kCount>
  void rates(double t_s, const State& y, State& out) const;
  template <std::size_t kCount>
  Step try_step(double h_s) const;
  void find_rate();
  Step step(double h_s) const;
  double acceleration(double t_s, const State& y, double& drive_N) const;
  Event event_in(const Step& step, double h_s) const;
  double locate(Event event, Step& step, double h_s) const;
  Event advance_once(double t_s);
  void start_moving();
  void commit(const Step& step, double h_s, Event event);

  Carriage carriage_;
  Masing masing_;
  MaxwellElements seal_;  // Coulomb friction; empty without
  Options options_;
  SineForce force_;
  double force_start_s_ = 0.0;
  double force_limit_N_;
  bool plain_;      // mass, payload and hysteresis only
  bool inner_;      // arm, lag or current loop
  double mass_kg_;  // of plain motion
  double fastest_rate_per_s_;
  State y_{};
  State rate_{};
  bool rate_known_ = false;
  double t_s_ = 0.0;
  double next_h_s_ = 0.0;
  double x_scale_m_ = 0.0;
  double v_scale_mps_ = 0.0;
  double swing_start_m_ = 0.0;
  double swing_v_mps_ = 0.0;
  double x_ref_m_ = 0.0;
  double highest_m_ = 0.0;
  double lowest_m_ = 0.0;
  std::size_t reversals_ = 0;
  mutable std::size_t steps_ = 0;
};

}  // namespace slipstack::sim
