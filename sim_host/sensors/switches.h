// SPDX-License-Identifier: Apache-2.0
// Limit switches and home switch of an axis, and the amplifier's contacts, as levels of a board's terminals.
#pragma once

#include <array>
#include <cstdint>

#include "sim_host/plant/axis.h"

namespace slipstack::sim {

struct Switches {
  /// Object 2010h for the terminals below; by sub-index.
  static constexpr std::array<std::uint32_t, 9> kWiring = {8, 1, 2, 3, 4, 5, 1, 0x0013, 0};

  double negative_m = 0.0;  ///< active up to here
  double positive_m = 0.0;  ///< active from here on
  double home_begin_m = 0.0;
  double home_end_m = 0.0;
  bool amplifier_ready = true;
  bool amplifier_fault = false;

  /// Levels with the axis here: terminals 1 and 2 are opened by the limit switches and 5 by the amplifier's
  /// fault, so that a broken wire is seen; 3 is closed by the home switch, 4 while the amplifier is ready.
  std::uint32_t levels(double position_m) const {
    const bool home = position_m >= home_begin_m && position_m <= home_end_m;
    return (position_m > negative_m ? 1U : 0U) | (position_m < positive_m ? 2U : 0U) | (home ? 4U : 0U) |
           (amplifier_ready ? 8U : 0U) | (amplifier_fault ? 0U : 16U);
  }
};

/// Limit switches at the ends of the stroke, and a home switch of 10 mm at a quarter of it.
inline Switches switches_of(const Axis& axis) {
  Switches switches;
  switches.positive_m = axis.stroke_m;
  switches.home_begin_m = 0.25 * axis.stroke_m;
  switches.home_end_m = switches.home_begin_m + 0.01;
  return switches;
}

}  // namespace slipstack::sim
