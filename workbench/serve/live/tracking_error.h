// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/can/commands/master.h"

namespace slipstack::workbench {

/// The position error of an axis in a move to and fro, sample by sample of the drive's trace.
struct TrackingError {
  std::vector<double> time_s;
  std::vector<double> reference_m;  ///< from where the move began
  std::vector<double> error_m;      ///< reference less position
  double rms_m = 0.0;
  double largest_m = 0.0;
};

/// Moves the axis by `travel_m` and back (driven_axis.h) while its trace records. Two seconds and the way
/// there and back; for an axis in whose way nothing can stand. Throws UsageError where the drive refuses.
TrackingError record_tracking_error(SdoClient& drive, double travel_m, const Show& show);

}  // namespace slipstack::workbench
