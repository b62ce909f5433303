// SPDX-License-Identifier: Apache-2.0
// A switch along the axis whose edges the encoder's counter catches: where they were, whenever the tick
// comes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "sim_host/plant/axis.h"
#include "sim_host/sensors/encoder.h"

namespace slipstack::sim {

struct CapturedSwitch {
  /// Of the simulated boards.
  static constexpr std::uint8_t kTerminal = 9;

  double begin_m = 0.0;  ///< closed from here
  double end_m = 0.0;    ///< to here

  bool high(double position_m) const { return position_m > begin_m && position_m <= end_m; }
  std::uint32_t levels(double position_m) const { return high(position_m) ? 1U << (kTerminal - 1U) : 0U; }

  /// Its edges on the way between two ticks, in their order: visit(counts, level behind it).
  template <class Visit>
  void passed(const Encoder& encoder, double from_m, double to_m, const Visit& visit) const {
    const bool up = to_m >= from_m;
    for (const double edge_m : {up ? begin_m : end_m, up ? end_m : begin_m}) {
      if ((from_m > edge_m) == (to_m > edge_m)) continue;
      visit(static_cast<std::int32_t>(encoder.counts(edge_m)), up == (edge_m == begin_m));
    }
  }
};

/// Of the simulated drives: 5 mm behind the middle of the stroke.
inline CapturedSwitch captured_switch_of(const Axis& axis) {
  return {0.5 * axis.stroke_m + 0.005, 0.5 * axis.stroke_m + 0.01};
}

}  // namespace slipstack::sim
