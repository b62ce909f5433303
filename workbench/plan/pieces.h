// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// A motion from rest to rest that shows something, from a place of its own.
struct Piece {
  std::string name;  ///< for people: "stroke at 5 mm/s"
  double start_m = 0.0;
  std::function<void(MotionBuilder&)> append;  ///< from start_m
};

/// What an axis within these limits may be asked for: strokes at speeds a factor apart, one-way motion that
/// slows down and speeds up, passes over the whole stroke, fast moves, sines of some pre-sliding travels at
/// three places. `presliding_m`: the travel over which hysteresis settles. Nothing exceeds the limits.
std::vector<Piece> possible_pieces(const AxisLimits& limits, double presliding_m);

}  // namespace slipstack::workbench
