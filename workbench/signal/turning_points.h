// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/base/interval.h"

namespace slipstack::workbench {

/// Where the axis reversed between two samples: before which of them, and how far it came. Hysteresis
/// remembers the turning point, which no sample shows.
struct TurningPoint {
  std::size_t before_sample = 0;
  double displacement_m = 0.0;
};

/// Adds the turning points within `samples` of a displacement read by an encoder of resolution `step_m` (0:
/// none are found), in the order of time: the tops of parabolas that bend by far more than a step. A zigzag
/// from sample to sample may be faster than they are: it goes beyond each of its corners by `beyond_corners`,
/// a share of its height; zero: it reverses at its samples. O(samples).
void find_turning_points(const std::vector<double>& displacement_m, Interval samples, double step_m,
                         double beyond_corners, std::vector<TurningPoint>& found);

}  // namespace slipstack::workbench
