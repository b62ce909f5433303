// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "workbench/estimate/terms/terms.h"
#include "workbench/plan/segments.h"

namespace slipstack::workbench {

/// Standstill before and after a motion.
inline constexpr double kSettle_s = 0.5;

/// Segments in sequence, each preceded by a move to its start.
struct Sequence {
  SetPoints motion;
  std::vector<std::pair<std::size_t, std::size_t>> samples;  ///< first and end sample of each segment
  /// The segment that contains each row of a measurement of the motion; -1 for rows of the moves between
  /// segments.
  std::vector<int> groups_of(const Measurement& measurement) const;
};

/// `model`: for the force that is left for the moves between the segments.
Sequence in_sequence(const std::vector<const MotionSegment*>& segments, const AxisLimits& limits,
                     const Terms& model, double rate_Hz);

/// Level of the dry friction of a model.
double friction_level_N(const Terms& terms);

}  // namespace slipstack::workbench
