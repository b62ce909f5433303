// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/can/commands/master.h"

namespace slipstack::workbench {

/// A planned motion in the positions of the drive, and what it asks of the axis.
struct DriveMotion {
  std::vector<double> position_m;
  double rate_Hz = 1000.0;
  double velocity_mps = 0.0;  ///< largest
  double acceleration_mps2 = 0.0;
  double force_N = 0.0;  ///< by the model; 0: not known
  // Where the axis has been in the logs that the plan was made of.
  double log_low_m = 0.0;
  double log_high_m = 0.0;
  /// The drive need not know its positions: its counts are places on the rail, as of the simulated axis.
  bool places_known = false;

  double low_m() const;
  double high_m() const;
};

/// One quantity of the plan beside what the axis may do.
struct PlanLimit {
  std::string quantity;
  std::string unit;
  double planned = 0.0;
  double allowed = 0.0;  ///< not a number: the drive says nothing
  bool fits = true;
  std::string source;  ///< of the limit: an object of the drive, or the logs
};

/// A plan against the limits of the axis behind a drive.
struct PlanOnAxis {
  std::vector<PlanLimit> limits;
  std::string refused;  ///< why it cannot be run; empty: it can
  double begin_m = 0.0;
  double now_m = 0.0;  ///< where the axis is
};

/// Compares a plan with software limits (607Dh), velocity, acceleration and current limit (2000h) of a drive.
/// Without software limits the plan must stay where the axis has been in the logs. Nothing is written. Throws
/// UsageError where the drive does not answer.
PlanOnAxis check_plan_on(SdoClient& drive, const DriveMotion& plan);

/// How a log of `rate_Hz` is recorded along a plan: set-points and samples each `period_ms`, every so many of
/// which are kept. A bus carries 1000 of them a second: from a rate beyond, or none in whole milliseconds,
/// the log has 1 kHz.
struct PlanSampling {
  int period_ms = 1;
  int every = 1;
  double rate_Hz() const { return 1e3 / (period_ms * every); }
};
PlanSampling sampling_for(double rate_Hz);

/// Runs a plan on the axis: moves to its first position at the drive's profile velocity, follows it in cyclic
/// synchronous position, disables the drive, and returns the log. As in `commission`: the drive stops by
/// itself where this master falls silent (2403h, 6007h); at the end, however it ends, SYNC and PDOs are as
/// the drive has them stored (NMT reset communication). For an axis in whose way nothing stands. Throws
/// UsageError where the plan does not fit, the drive refuses, stops, or is stopped by a limit switch, and
/// Cancelled.
Recording run_plan_on(SdoClient& drive, const DriveMotion& plan, const PlanSampling& sampling,
                      const Show& show);

}  // namespace slipstack::workbench
