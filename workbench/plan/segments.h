// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// A part of a planned motion, from standstill to standstill, with a start position of its own.
struct MotionSegment {
  std::string name;  ///< as text: "move there and back at 5 mm/s"
  double start_m = 0.0;
  std::function<void(MotionBuilder&)> append;  ///< from start_m
};

/// The segments from which a plan is made, all within the limits: traverses at speeds a constant factor
/// apart, motion in one direction with varying speed, passes over the whole stroke, fast moves, and sines of
/// some pre-sliding travels at three positions. `presliding_m`: the travel after which the hysteresis is
/// nearly at its level.
std::vector<MotionSegment> possible_segments(const AxisLimits& limits, double presliding_m);

}  // namespace slipstack::workbench
