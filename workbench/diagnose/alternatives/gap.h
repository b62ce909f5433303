// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// A carriage behind a gap in the drive, whose encoder is on the motor's side: what the force lacks of that
/// of a rigid drive, for a carriage of one kilogram. The flanks are rigid (Nordin and Gutman 2002,
/// "Controlling mechanical systems with backlash - a survey", section 2), without rebound: while one flank
/// pushes, the carriage follows the motor half a gap behind it; where the force that the flank transmits
/// would pull, the carriage leaves it and its friction decelerates it until it meets the other flank, which
/// gives it the motor's velocity at once. Friction is one stop operator over the way of the carriage. A
/// coefficient of restitution was tried: on 12 simulated axes with elastic flanks the error was as large with
/// it. Cost: some ten operations a sample, in the gap up to sixteen times as many.
class GapInDrive {
 public:
  struct Parameters {
    double gap_m = 0.0;              ///< free way
    double deceleration_mps2 = 0.0;  ///< friction by mass of the carriage
    double slip_m = 0.0;             ///< slip distance of that friction
  };
  /// `tick_s`: between two samples.
  GapInDrive(const Parameters& parameters, double tick_s);

  /// The carriage is in the middle of the gap and moves with the motor.
  void reset(const Sample<double>& sample);
  /// Force per mass of the carriage [m/s2] less that of a carriage without a gap.
  double step(const Sample<double>& sample);

 private:
  double in_contact(const Sample<double>& sample);
  double in_gap(const Sample<double>& sample);

  double half_gap_m_;
  double deceleration_mps2_;
  double slip_m_;
  double tick_s_;
  int substeps_;
  int flank_ = 0;  ///< the direction in which the motor pushes; 0: in the gap
  double motor_m_ = 0.0;
  double carriage_m_ = 0.0;
  double carriage_mps_ = 0.0;
  double deflection_ = 0.0;        ///< of the friction of the carriage, -1 to 1
  double rigid_deflection_ = 0.0;  ///< of the friction that it would have without a gap
};

}  // namespace slipstack::workbench
