// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "workbench/plan/expected_evidence.h"
#include "workbench/plan/motion.h"

namespace slipstack::workbench {

/// What is known of the axis before the experiment.
struct Knowledge {
  Terms model;    ///< the baseline
  Terms effects;  ///< those to tell apart, as they are expected to be
  double encoder_resolution_m = 0.0;
  double force_noise_N = 0.0;  ///< white, per sample
  double rate_Hz = 1000.0;
};

struct PlanOptions {
  AxisLimits limits;
  double seconds = 60.0;  ///< the motion may last
  std::function<void(const std::string& stage, double fraction)> progress;
};

struct Plan {
  SetPoints motion;
  std::vector<std::string> pieces;  ///< in order, with how often
  Terms effects;                    ///< as they were expected
  std::vector<ExpectedEvidence> expected;
  double peak_force_N = 0.0;  ///< by the model with the effects
};

/// The motion within the limits that tells the effects apart best, by its expected evidence: every possible
/// piece (pieces.h) is run through the model and through the same conditioning as a log, its information
/// about every pair of effects found, and pieces are taken, the most telling for their time first, until the
/// time is used up or nothing more is learned. Deterministic. Cost: a few seconds.
///
/// Throws std::invalid_argument where no piece fits into the limits.
Plan plan_experiment(const Knowledge& knowledge, const PlanOptions& options);

}  // namespace slipstack::workbench
