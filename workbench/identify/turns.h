// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/identify/parts.h"

namespace slipstack::workbench {

/// Where the axis turned round between two samples: before which of them, and how far it came. Hysteresis
/// remembers the turning point, which no sample shows.
struct Turn {
  std::size_t before_sample = 0;
  double displacement_m = 0.0;
};

/// Turns of all parts that lie on an encoder's grid, in the order of time: the tops of parabolas that bend by
/// far more than a step. A zigzag from sample to sample may be faster than they are: it goes beyond each of
/// its corners by `beyond_corners`, a share of its height; zero: it turns at its samples. O(samples).
std::vector<Turn> find_turns(const std::vector<double>& displacement_m, const std::vector<LogPart>& parts,
                             double beyond_corners = 0.0);

}  // namespace slipstack::workbench
