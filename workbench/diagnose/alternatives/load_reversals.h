// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// When the force that the drive transmits to a carriage changes its sign: where there is play in the drive,
/// the flank that pushed is left then, and the other one is hit (Nordin and Gutman 2002, "Controlling
/// mechanical systems with backlash - a survey", section 2). The force, by mass of the carriage, is its
/// acceleration and its friction, one stop operator over the way. Cost: some ten operations a sample.
class LoadReversals {
 public:
  struct Parameters {
    double deceleration_mps2 = 0.0;  ///< friction by mass of the carriage
    double slip_m = 0.0;             ///< slip distance of that friction
  };
  /// `tick_s`: between two samples.
  LoadReversals(const Parameters& parameters, double tick_s);

  /// No reversal has been seen.
  void reset(const Sample<double>& sample);
  void step(const Sample<double>& sample);

  /// The force in units of the friction.
  double load() const { return load_; }
  /// Its sign, +1 or -1; 0 before the first reversal.
  double side() const { return side_; }
  /// Time since the sign changed [s]; huge before that.
  double since_s() const { return since_s_; }

 private:
  double deceleration_mps2_;
  double slip_m_;
  double tick_s_;
  double position_m_ = 0.0;
  double deflection_ = 0.0;
  double load_ = 0.0;
  double side_ = 0.0;
  double since_s_ = 0.0;
};

}  // namespace slipstack::workbench
