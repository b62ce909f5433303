// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/frequency/response.h"

namespace slipstack::workbench {

/// How far a loop is from instability, by its response at rising frequencies. NaN: the measured band has no
/// such point.
struct Margins {
  double peak_sensitivity = 0.0;  ///< largest |1 / (1 + L)|
  double modulus = 0.0;           ///< smallest |1 + L|, its reciprocal
  double peak_Hz = 0.0;
  double gain = 0.0;  ///< by how much the gain may grow: 1 / |L| where L crosses the negative axis
  double gain_Hz = 0.0;
  double gain_down = 0.0;  ///< by how much it may shrink (below 1); 0: to nothing
  double phase_rad = 0.0;  ///< smallest of the angles between L and -1 where |L| = 1
  double phase_Hz = 0.0;
  double delay_s = 0.0;       ///< that the phase margin pays for
  double crossover_Hz = 0.0;  ///< the highest at which |L| = 1
  double bandwidth_Hz = 0.0;  ///< up to which |1 / (1 + L)| stays below 1 / √2
};

/// Crossings are interpolated between neighbouring points, the logarithm of |L| and its angle over the
/// logarithm of the frequency. O(points).
Margins margins_of(const std::vector<double>& frequency_Hz, const std::vector<Complex>& loop);

/// By how many turns 1 + `loop` winds more about 0 than 1 + `stable` does, over the band, of the two-sided
/// Nyquist curves. Where the loop that was measured runs stably, the other one is stable too if it is 0
/// (Nyquist; the controllers have no unstable poles, and both loops agree far below and above the band).
int extra_turns(const std::vector<Complex>& loop, const std::vector<Complex>& stable);

}  // namespace slipstack::workbench
