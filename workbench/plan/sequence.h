// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "workbench/estimate/terms/terms.h"
#include "workbench/plan/pieces.h"

namespace slipstack::workbench {

/// At rest before and after a motion.
inline constexpr double kSettle_s = 0.5;

/// Pieces one after the other, each reached by a move of its own.
struct Sequence {
  SetPoints motion;
  std::vector<std::pair<std::size_t, std::size_t>> samples;  ///< first and end of each piece
  /// The piece in which each row of a measurement of the motion lies, -1 on the way from one to the next.
  std::vector<int> groups_of(const Measurement& measurement) const;
};

/// `model` says how much force is left for the moves between the pieces.
Sequence in_sequence(const std::vector<const Piece*>& pieces, const AxisLimits& limits, const Terms& model,
                     double rate_Hz);

/// Level of the dry friction that a model has.
double friction_level_N(const Terms& terms);

}  // namespace slipstack::workbench
