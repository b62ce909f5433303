// SPDX-License-Identifier: Apache-2.0
// The measurements of [2], simulated: loops of stepped amplitude at several preloads and on other guideways.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_host/experiments/setup.h"
#include "workbench/papers/analysis/guideway.h"
#include "workbench/papers/analysis/loop_log.h"

namespace slipstack::workbench {

/// The test: a virgin curve under slow force sines, and the sensors.
struct LoopTest {
  std::vector<double> amplitudes_m;  // rising
  double frequency_Hz = 1.0;
  double sample_rate_Hz = 1000.0;
  double encoder_resolution_m = 0.0;
  double force_noise_N = 0.0;
  std::uint64_t seed = 1;
};

/// The test of a set-up: its amplitudes and sensors, 1000 samples to a loop at most.
LoopTest loop_test_of(const sim::ExperimentSetup& setup);

/// Loops at the force amplitudes that reach the displacement amplitudes; each is the mean of ten. Amplitudes
/// below what the encoder resolves (twenty steps from end to end) are left out. Throws std::invalid_argument
/// when none remains or a force exceeds the friction.
std::vector<AveragedLoop> characterize(const sim::VirginCurve& curve, const LoopTest& test);

/// A preload as a multiple of that of the set-up.
struct PreloadSeries {
  double preload = 1.0;
  std::vector<AveragedLoop> loops;
};

/// The same at several preloads: the forces of the virgin curve are proportional to their square root ([2],
/// 4.4.2).
std::vector<PreloadSeries> characterize_preloads(const sim::VirginCurve& curve, const LoopTest& test,
                                                 const std::vector<double>& preloads);

/// A curve with both axes multiplied.
sim::VirginCurve scaled(const sim::VirginCurve& curve, const Scaling& factors);

/// A loop close to rolling of one guideway, and the guideway.
struct GuidewayLoop {
  BallContact contact;
  AveragedLoop loop;
};

/// The guideways that [2] tried, one parameter changed at a time from `reference`: loads 10, 25, 55 N, groove
/// angles 60°, 90°, 120°, balls of 1.5 and 6 mm; the loop of each, measured to the same share of its
/// saturation.
std::vector<GuidewayLoop> guideways_tried(const sim::VirginCurve& curve, const BallContact& reference,
                                          const LoopTest& test);

}  // namespace slipstack::workbench
