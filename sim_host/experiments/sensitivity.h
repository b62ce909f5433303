// SPDX-License-Identifier: Apache-2.0
// Where small changes of the saturation level move the frequency response most: the sensitive region of [1].
#pragma once

#include <vector>

#include "sim_host/experiments/stepped_sine.h"

namespace slipstack::sim {

/// The set-up with the saturation level of its virgin curve changed by a share, its first slope unchanged:
/// levels and lengths are scaled alike, so that only the level and the travel to it change.
ExperimentSetup with_level(const ExperimentSetup& setup, double share);

/// The response at one force and frequency, and its change.
struct SensitivityPoint {
  double force_N = 0.0;
  double frequency_Hz = 0.0;
  double response_m_per_N = 0.0;
  double spread = 0.0;       // |G(level + ε) − G(level − ε)| / |G|
  double sensitivity = 0.0;  // spread/(2ε): relative change of the response over relative change of the level
};

/// From sweeps of the same request with the level raised by ε, lowered by ε, and as it is.
std::vector<SensitivityPoint> sensitivity(const std::vector<SweepChain>& plain,
                                          const std::vector<SweepChain>& raised,
                                          const std::vector<SweepChain>& lowered, double share);

}  // namespace slipstack::sim
