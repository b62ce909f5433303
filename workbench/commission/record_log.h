// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// A record of a motion as a log (docs/log-format.md).
std::string log_csv(const AxisRecord& record, const Nameplate& nameplate);

/// Largest magnitude; zero of no values.
double largest(const std::vector<double>& values);

/// How well the axis follows, in each cycle of a motion.
struct CycleErrors {
  std::vector<double> rms_m;
  std::vector<double> reversal_rms_m;  ///< in the 50 ms after reversals of the reference
};

/// `record` holds as many whole cycles as fit, each of `cycle_s`; the first is left out, and what is behind
/// the last.
CycleErrors cycle_errors(const AxisRecord& record, double cycle_s);

}  // namespace slipstack::workbench
