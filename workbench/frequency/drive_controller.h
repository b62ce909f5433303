// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "workbench/frequency/response.h"

namespace slipstack::workbench {

struct DriveNotch {
  double frequency_Hz = 0.0;  ///< 0: off
  double damping = 0.1;
  double depth = 0.1;
};

/// What of the drive's parameters (2000h) closes the loop.
struct DriveController {
  double tick_s = 1e-4;
  double mass_kg = 1.0;  ///< of the model: what the state estimate expects of a force
  double observer_rad_per_s = 400.0;
  double position_gain_per_s = 0.0;
  double velocity_gain_N_s_per_m = 0.0;
  double integral_per_s = 0.0;
  double disturbance_share = 0.0;
  std::array<DriveNotch, 2> notch{};
};

/// The drive's feedback in its discrete form, from position to force, at many frequencies.
///
/// Per tick: the state estimate (position, velocity, disturbance) is predicted by the force of the tick
/// before and corrected by the counts (firmware/control/force/state_estimate.h); then
///   F = notch(p + i) − share · m · d,   p = Kv (Kp (r − x) − v),   i' = i + Ki T p
/// (firmware/control/force/feedback.h). With z = e^(jωT) that is a linear system of three states, solved at
/// each frequency; the force of the tick before, which the estimate expects, closes an inner loop that is
/// part of the controller. No delay is left out: the estimate acts in the tick that reads the counts, and the
/// hold to the next tick is in the measured plant.
class FeedbackResponse {
 public:
  /// Everything but the gains, which may then change: observer, mass and tick. O(frequencies).
  FeedbackResponse(const DriveController& drive, const std::vector<ResponsePoint>& at);

  /// −F / y at every frequency, N/m: loop = plant × this.
  std::vector<Complex> of(const DriveController& gains) const;
  /// F / r at every frequency, N/m: the force that a change of the position reference makes at an axis that
  /// does not move. Measured, it is this times the sensitivity.
  std::vector<Complex> of_reference(const DriveController& gains) const;

 private:
  // The estimated state over the counts, and over the force of the tick before.
  struct Estimate {
    Complex z;
    std::array<Complex, 3> by_counts;
    std::array<Complex, 3> by_force;
  };
  // Integral and notches.
  static Complex filter(const DriveController& gains, Complex z);
  // From an estimated state.
  static Complex force(const DriveController& gains, const Estimate& at, const std::array<Complex, 3>& state);

  std::vector<Estimate> estimates_;
};

/// A notch of the drive at z (firmware/control/force/notch.h).
Complex notch_response(const DriveNotch& notch, double tick_s, Complex z);

}  // namespace slipstack::workbench
