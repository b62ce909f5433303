// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "sim_host/motion/segment.h"
#include "sim_host/plant/axis.h"

namespace slipstack::workbench {

/// A motion sampled at the ticks of a controller, and what of it is judged.
struct Trajectory {
  /// A move to rest and the dwell behind it.
  struct Move {
    double length_m = 0.0;   ///< nominal; on a short axis the move may be shorter
    std::size_t end = 0;     ///< tick at which the reference comes to rest
    std::size_t dwells = 0;  ///< ticks until it moves on
  };

  double tick_s = 1e-4;
  std::vector<sim::MotionPoint> points;
  std::vector<std::size_t> reversals;  ///< ticks at which the direction changes, with or without a dwell
  std::vector<Move> moves;

  std::size_t size() const { return points.size(); }
  double duration_s() const { return static_cast<double>(size()) * tick_s; }
};

/// A motion of this duration, by its law; its reversals are found, it has no moves. Accelerations are means
/// over the tick that begins there, as the firmware's reference has them (ReferencePoint): what a current
/// that is held must give.
Trajectory sampled(const std::function<sim::MotionPoint(double)>& motion, double duration_s, double tick_s);

/// What compensators are tuned on: the first `seconds` of the programme of the axis and the seed
/// (sim::draw_programme()): loops in pre-sliding, traverses, moves.
Trajectory training_motion(const sim::Axis& axis, std::uint64_t seed, double seconds, double tick_s);

/// What they are judged by: sines of 5 µm to 10 mm about the middle of the axis, then moves of 10 µm, 1 mm
/// and 100 mm there and back, with dwells. `brief`: sines and moves of 1 mm only. No part of it is a part of
/// the training motion.
Trajectory judged_motion(const sim::Axis& axis, double tick_s, bool brief);

/// One axis of a circle of this radius, two turns and one before them to gain speed: `sine` of two axes, the
/// one that begins at the middle; the other begins at the side.
Trajectory circle(const sim::Axis& axis, double radius_m, double tick_s, bool sine);

/// Tick of a circle from which on it has its speed.
std::size_t circle_begin(const Trajectory& circle);

}  // namespace slipstack::workbench
