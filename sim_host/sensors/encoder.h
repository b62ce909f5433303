// SPDX-License-Identifier: Apache-2.0
// Incremental encoder: counts, resolution, an arbitrary phase, and lost counts.
#pragma once

#include <cstdint>
#include <utility>

#include "sim_host/plant/effects/effects.h"

namespace slipstack::sim {

class Encoder {
 public:
  /// `phase` in counts (0 … 1) is the position within the grating at which the axis was switched on.
  explicit Encoder(double resolution_m, double phase = 0.0) : resolution_m_(resolution_m), phase_(phase) {}

  /// From now on, counts are lost at the given times.
  void set_slip(EncoderSlip slip) { slip_ = std::move(slip); }

  /// Nearest count for a true position at a time. Precondition: resolution > 0 and |position/resolution| <
  /// 2⁵³.
  std::int64_t counts(double position_m, double t_s = 0.0) const;
  /// The same in metres; without a resolution, the true position.
  double position_m(double position_m, double t_s = 0.0) const;
  double resolution_m() const { return resolution_m_; }

 private:
  double resolution_m_;
  double phase_;
  EncoderSlip slip_;
};

}  // namespace slipstack::sim
