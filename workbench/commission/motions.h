// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/loop/live_axis.h"
#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// The room in which the axis is moved: nine tenths of its travel, and accelerations for which half of its
/// force suffices, whatever is left of it beside the friction.
AxisLimits first_limits(const Nameplate& nameplate, double mass_kg, double friction_N);

/// At which the axis comes to where a motion begins: a quarter of the room in a second, 0.1 m/s at most.
double approach_mps(const AxisLimits& limits);

/// Where the holding motion holds its place, s.
inline constexpr double kHoldFrom_s = 0.3;
inline constexpr double kHoldTo_s = 0.7;
/// Little: the axis holds its place, then 50 µm to and fro. Whether the feedback is steady shows here.
SetPoints holding_motion(const AxisLimits& limits);

/// From end to end of the room, at twice the speed of approach. 10 s, on a slow axis 30.
SetPoints travel_motion(const AxisLimits& limits);

/// What an axis is asked first, at this share of its limits (`pace` at most 1): sines in pre-sliding at two
/// places, traverses at several speeds, moves over what of the room is reached in some seconds. 20 s.
SetPoints first_look(const AxisLimits& room, double pace, double encoder_resolution_m);

/// By which the compensation is judged, and which no fit sees: sines of 20 µm and some millimetres, moves to
/// and fro over a third of the room at three quarters of the limits. The same cycle, again and again, so that
/// its scatter shows; the first one is to be left out, because what came before is still in the hysteresis.
struct TrackingTest {
  static constexpr std::size_t kCycles = 5;
  SetPoints motion;
  std::size_t cycle_points = 0;
};
TrackingTest tracking_test(const AxisLimits& room);

}  // namespace slipstack::workbench
