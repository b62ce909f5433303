// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workbench/console/progress.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/long_logs/unit_sums.h"
#include "workbench/plan/segment_choice.h"

namespace slipstack::workbench {

/// What `slipstack experiment plan` was asked for.
struct PlanRequest {
  std::string effects;
  std::vector<std::string> logs;
  std::string model;
  std::optional<std::string> model_content;  ///< where `model` is no file
  std::string baseline;
  std::string limits;
  std::vector<std::string> user_effects;
  std::optional<double> seconds;  ///< how long the motion may last; default: as long as the log needs
  double rate_Hz = 1000.0;
  LogsInMemory in_memory;  ///< those of `logs` that are no files
};

/// What is known of the axis, and how it is recorded.
struct KnownAxis {
  std::unique_ptr<Measurement> measurement;  ///< of long logs, an excerpt
  MotionExtremes reached;                    ///< in all of the logs; the force no less than model_force_N
  double measured_force_N = 0.0;             ///< that the logs have surely reached
  double model_force_N = 0.0;                ///< largest of the baseline along the logs
  FittedModel base;                          ///< fitted to the logs; empty without logs
  Knowledge knowledge;

  /// What the logs show of effects, as they are expected to be; none without logs.
  std::vector<ExpectedEvidence> evidence_in_hand(const Terms& effects) const;
};

/// From the logs, the model, or assumptions that hold for rolling guideways. `ids`: the effects to plan for.
KnownAxis known_axis(const PlanRequest& request, const std::vector<std::string>& ids, Progress& progress);

/// The assumptions made where there is neither log nor model, as text.
std::string assumed_text();

}  // namespace slipstack::workbench
