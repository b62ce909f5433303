// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/plan/expected_evidence.h"
#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// What is known about the axis before the experiment.
struct Knowledge {
  Terms model;    ///< the baseline
  Terms effects;  ///< the effects to distinguish, as they are expected to be
  double encoder_resolution_m = 0.0;
  double force_noise_N = 0.0;  ///< white, per sample
  ExpectedScatter scatter;     ///< about a model with all of these effects
  double rate_Hz = 1000.0;
};

struct PlanOptions {
  AxisLimits limits;
  double seconds = 60.0;  ///< longest duration of the motion
  /// The evidence for effects, as they are expected, that is in hand already; may be empty.
  std::function<std::vector<ExpectedEvidence>(const Terms& effects)> in_hand;
  std::function<void(const std::string& stage, double fraction)> progress;
  /// Longest duration of a motion that is repeated to show more than what is in hand, where that is longer.
  double repeated_s = 0.0;
};

struct Plan {
  SetPoints motion;
  std::vector<std::string> segments;  ///< in order of the motion
  Terms effects;                      ///< as expected
  std::vector<ExpectedEvidence> expected;
  std::vector<ExpectedEvidence> in_hand;  ///< that of the options
  double peak_force_N = 0.0;              ///< by the model with the effects
};

/// The motion within the limits that distinguishes the effects best, by its expected evidence. Every possible
/// segment (segments.h) is simulated with the model and conditioned like a log, and its information about
/// every pair of effects is computed. Then segments are chosen greedily, by their gain of information per
/// time, until the time is used up or the gain becomes negligible. Where that is less than what is in hand,
/// the motion is repeated until it is more, within the time for that. Deterministic. Cost: a few seconds.
///
/// Throws std::invalid_argument where no segment satisfies the limits.
Plan plan_experiment(const Knowledge& knowledge, const PlanOptions& options);

}  // namespace slipstack::workbench
