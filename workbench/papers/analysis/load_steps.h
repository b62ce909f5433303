// SPDX-License-Identifier: Apache-2.0
// A calibration of a force transducer in load steps: the record, and the parts into which [3] separates it.
#pragma once

#include <cstddef>
#include <vector>

#include "sim_host/experiments/calibration.h"

namespace slipstack::workbench {

/// A record in load steps: preloads straight from zero to full scale and back, then one cycle from zero over
/// steps to full scale and back to zero, with loops inside or without.
struct StepRecord {
  std::vector<sim::LoadStep> steps;
  std::size_t cycle = 0;     // index of the zero at which the cycle begins
  std::size_t top = 0;       // index of the full-scale reading of the cycle
  std::size_t preloads = 0;  // before the cycle
  double full_scale_N = 0.0;
};

/// Finds the cycle in a record. Throws std::invalid_argument, naming the step counted from 1, when there are
/// fewer than five steps up ([3], section 2), times do not rise, a load is negative, or the cycle does not
/// begin and end at zero load.
StepRecord step_record(std::vector<sim::LoadStep> steps);

/// The parts of a cycle after [3], section 2; all in mV/V.
struct Reversibility {
  double sensitivity = 0.0;         // S, mV/V per N, of the line through origin and full scale
  double zero_drift = 0.0;          // at the end of the cycle
  std::vector<double> deviation;    // h₂ of every reading of the cycle: off the line, drift removed
  std::vector<double> load_N;       // of the levels, rising, that were read on the way up and down
  std::vector<double> linearity;    // (h_up + h_down)/2 at the levels
  std::vector<double> hysteresis;   // (h_up − h_down)/2 at the levels: |.| is d_h
  std::vector<double> rise;         // h_up at the levels
  double largest_hysteresis = 0.0;  // max d_h
};

/// The offset at zero load is subtracted, then the drift in proportion to time. Levels read several times on
/// one way (loops inside) count by their first reading. Throws std::invalid_argument when fewer than five
/// levels were read both ways or the signal does not grow with load.
Reversibility reversibility(const StepRecord& record);

}  // namespace slipstack::workbench
