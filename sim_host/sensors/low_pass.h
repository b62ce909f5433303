// SPDX-License-Identifier: Apache-2.0
// The low pass by which a recorded signal is smoothed before it is published.
#pragma once

#include <vector>

namespace slipstack::sim {

/// Butterworth low pass of a whole record (bilinear transform with its cut held; Oppenheim, Schafer, Buck
/// 1999, 7.1): |H|² = 1 / (1 + (f/cut)^(2 order)) where f is far below the rate. Once forward, or forward and
/// backward with no phase and |H|². At rest on its first sample, either way. Throws std::invalid_argument
/// unless the order is even and positive and the cut between 0 and half of the rate.
std::vector<double> low_passed(std::vector<double> signal, double rate_Hz, double cut_Hz, int order,
                               bool zero_phase);

}  // namespace slipstack::sim
