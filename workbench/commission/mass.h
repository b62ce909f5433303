// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// What a pulse of the force, to and fro, says of an axis.
struct PulseResult {
  double moved_m = 0.0;        ///< while the force pushed
  double mass_kg = 0.0;        ///< 0: too little motion for it
  double mass_error_kg = 0.0;  ///< one standard error, from the scatter about the two parabolas
  double friction_N = 0.0;     ///< that slides
};

/// Under F the axis speeds up by (F − R)/m, against F it slows down by (F + R)/m while it still moves ahead,
/// with the same friction R: m = 2F / (a1 − a2), R = −m (a1 + a2) / 2, with a1 and a2 by parabolas through
/// the positions. Neither needs the other: the mass is right whatever the friction. `force_N`, `seconds`: of
/// the pulse (LiveAxis::pulse()), as they were asked for.
PulseResult result_of_pulse(const AxisRecord& record, double force_N, double seconds,
                            double encoder_resolution_m);

}  // namespace slipstack::workbench
