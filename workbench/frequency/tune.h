// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "workbench/frequency/drive_controller.h"
#include "workbench/frequency/margins.h"

namespace slipstack::workbench {

/// What a tuning must keep to.
struct TuneRequest {
  double modulus_margin = 0.5;
  double largest_bandwidth_rad_per_s = 2000.0;  ///< of the velocity loop
};

struct Tuning {
  DriveController gains;
  Margins margins;  ///< predicted
  std::size_t notches = 0;
};

/// Loop of plant and feedback at each point.
std::vector<Complex> loop_of(const std::vector<ResponsePoint>& plant, const std::vector<Complex>& feedback);

/// Frequencies of resonances of the plant, the highest first: where the curvature |P| ω² stands out by 1.5
/// over its median in an octave around, by more than four standard deviations.
std::vector<double> resonances(const std::vector<ResponsePoint>& plant);

/// The gains with the stiffest loop (largest Kp Kv, the force per position error) that keep the modulus
/// margin at every measured frequency and leave the loop stable, judged against the loop that runs
/// (extra_turns()).
///
/// One bandwidth w sets Kv = m w and Kp = Ki = w / n for n from 3 to 8, without or with up to two notches at
/// resonances; w rises by 3 % from a tenth of the present one while the margin is kept. At the upper end of
/// the band the loop must be below 1 − margin, since nothing is known beyond. The mass comes from the drive.
/// Nothing when no gains keep the margin. O(points × 10^4).
std::optional<Tuning> propose(const std::vector<ResponsePoint>& plant, const DriveController& present,
                              const TuneRequest& request);

}  // namespace slipstack::workbench
