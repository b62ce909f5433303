// SPDX-License-Identifier: Apache-2.0
// From a record of position and force to averaged loops, one for each amplitude and position.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "workbench/papers/analysis/loop_figures.h"

namespace slipstack::workbench {

/// The mean of `count` consecutive loops of one amplitude at one position ([2], section 4.2: ten are
/// averaged).
struct AveragedLoop {
  Loop loop;                     // rising branch, then falling branch
  double position_m = 0.0;       // middle of the loop
  std::size_t count = 0;         // loops in the mean
  std::size_t first_sample = 0;  // of the first of them
  LoopFigures figures;
  double damping_ratio_spread = 0.0;  // standard deviation of ζᵣ over the single loops
};

/// Finds the loops in a record. Turning points count when the motion reverses by more than noise and
/// quantisation, both estimated from the record; a loop is closed when it ends within 5 % of its height from
/// its beginning; neighbours within 5 % in amplitude and 10 % in position belong together. Of three and more
/// loops the first is left out: it contains the transition from the amplitude before. The rest, at most
/// `most` of them, are averaged at common positions.
///
/// Throws std::invalid_argument when sizes differ or no closed loop is found.
std::vector<AveragedLoop> averaged_loops(std::span<const double> position_m, std::span<const double> force_N,
                                         std::size_t most = 10);

/// Turning points of a record: first and last sample, and every reversal of more than `threshold_m`.
std::vector<std::size_t> turning_points(std::span<const double> position_m, double threshold_m);

/// The smallest motion above noise and quantisation: eight standard deviations of the noise (from third
/// differences, by their median) or one and a half steps of the sensor.
double motion_threshold_m(std::span<const double> position_m);

}  // namespace slipstack::workbench
