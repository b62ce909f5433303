// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// As many slip distances as `fitted` has, from its shortest to its longest (or from a quarter of an encoder
/// step, where the shortest element holds more than its share of the level), denser where its virgin curve is
/// curved. A polygon with corners a distance h apart (in the logarithm of displacement) misses a curve by
/// h^2/8 times the level that slips per step, so the density is made proportional to the square root of that
/// level. `fitted`: presliding_hysteresis on a grid even in the logarithm; the levels of several logs are
/// added.
std::vector<double> refined_slip_distances(const Term& fitted, double encoder_resolution_m);

}  // namespace slipstack::workbench
