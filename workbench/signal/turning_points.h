// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// A reversal of the axis between two samples: the sample that follows it and the displacement reached. The
/// hysteresis depends on the displacement at the turning point itself, which lies beyond every sample.
struct TurningPoint {
  std::size_t before_sample = 0;
  double displacement_m = 0.0;
};

/// Appends the turning points within `samples` of a displacement read by an encoder of resolution `step_m`
/// (0: none are found), in the order of time. Each is the vertex of a parabola whose second difference is
/// many encoder steps. An axis that reverses at every sample (a zigzag) has no such parabola: it is assumed
/// to go beyond each of its corners by `beyond_corners`, a share of the zigzag's height; with zero it
/// reverses at the samples. O(samples).
void find_turning_points(const std::vector<double>& displacement_m, Interval samples, double step_m,
                         double beyond_corners, std::vector<TurningPoint>& found);

}  // namespace slipstack::workbench
