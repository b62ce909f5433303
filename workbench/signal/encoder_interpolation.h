// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

namespace slipstack::workbench {

/// An assumption on how the axis moved within cells where no crossing shows it.
struct UnobservedMotion {
  /// Stays in a cell of up to so many samples follow the cubic, and so do longer ones that are passed through
  /// at a steady speed. In all other stays the axis may have crept to and fro: it is assumed to move by way
  /// of the two `places`.
  double longest_known = std::numeric_limits<double>::infinity();
  /// Shares of the cell, from the border at which it was entered.
  std::array<double, 2> places{0.5, 0.5};
  /// The axis enters and leaves at the speeds of the neighbouring cells; else each part of the way takes a
  /// third of the time.
  bool at_speed = false;
};

/// Position from encoder readings on a grid of `resolution_m`, finer than the grid where the axis is slow.
///
/// A reading says only in which cell the axis is; the instant at which the reading changes says exactly where
/// the axis is. Where the axis crosses cells in nearly every sample the readings are returned unchanged;
/// elsewhere a cubic through the crossings, kept inside the cell, replaces the staircase. This matters in
/// pre-sliding, where a displacement of micrometres changes the force by newtons, and where the staircase has
/// so low frequencies that no filter removes it. Readings that are not on a grid (resolution 0) are returned
/// unchanged. Cost O(n).
std::vector<double> interpolate_between_steps(std::span<const double> position_m, double resolution_m,
                                              const UnobservedMotion& unobserved = {});

}  // namespace slipstack::workbench
