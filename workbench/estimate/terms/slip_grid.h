// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// As many slip distances as `fitted` has, from its shortest to its longest (or from a quarter of an encoder
/// step, where the shortest holds more than its share), denser where its virgin curve bends. A polygon with
/// corners a step h apart (in the logarithm of displacement) misses a curve by h^2/8 times the level that
/// slips per step, so the density goes with the root of that level. `fitted`: presliding_hysteresis on an
/// even grid; levels of several logs add up.
std::vector<double> refined_slip_distances(const Term& fitted, double encoder_resolution_m);

}  // namespace slipstack::workbench
