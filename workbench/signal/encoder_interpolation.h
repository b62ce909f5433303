// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

namespace slipstack::workbench {

/// What no crossing tells: how the axis went about within a cell.
struct UnobservedMotion {
  /// Samples. The cubic is believed in a shorter stay, and in a longer one on the way through with steady
  /// speed; else the axis may have crept to and fro as it liked, and is taken to go by the two `places`.
  double longest_known = std::numeric_limits<double>::infinity();
  /// Shares of the cell, from where it was entered.
  std::array<double, 2> places{0.5, 0.5};
  /// In and out as fast as it came and goes, so that it turns at once: else in a third of the time each.
  bool at_speed = false;
};

/// Position from encoder readings on a grid of `resolution_m`, finer than the grid where the axis is slow.
///
/// A reading says only in which cell the axis is; the instant at which it leaves the cell says exactly where.
/// Readings are taken as they are where the axis crosses cells in nearly every sample; elsewhere a cubic
/// through the crossings, kept inside the cell, replaces the staircase. This matters in pre-sliding, where
/// micrometres are newtons: a staircase there is structure that no filter removes. Readings that are not on
/// the grid (resolution 0) are returned as they are. Cost O(n).
std::vector<double> interpolate_between_steps(std::span<const double> position_m, double resolution_m,
                                              const UnobservedMotion& unobserved = {});

}  // namespace slipstack::workbench
