// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/identify/measurement.h"
#include "workbench/identify/terms.h"

namespace slipstack::workbench {

/// What no model can explain at the rows: the noise of the force through the filter; the encoder's
/// quantisation through mass times acceleration; and what quantisation does to the hysteresis, which is not
/// white where the axis is slow, so it is tried out: the motion is read again by an encoder whose grid is
/// shifted, and the model evaluated on both.
class NoiseFloor {
 public:
  explicit NoiseFloor(const Measurement& measurement)
      : measurement_(measurement), shifted_(measurement.requantised()) {}

  /// Standard deviation [N]. Cost: two evaluations of the model over the log.
  double of(const Terms& terms) const;

 private:
  const Measurement& measurement_;
  Measurement shifted_;
};

}  // namespace slipstack::workbench
