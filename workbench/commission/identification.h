// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/commission/commission_folder.h"
#include "workbench/console/progress.h"
#include "workbench/plan/motion.h"
#include "workbench/plan/next_experiment.h"

namespace slipstack::workbench {

/// Diagnoses the logs of one axis together. The models on the way from mass and hysteresis to the whole
/// explanation, each with one effect more, go into the folder as `<name>_1.toml` and so on. Returns
///
///   {"verdict", "unexplained": "" or where, "models": [{"added", "effect", "file"}],
///    "question": null or {"effects": [], "reason"},
///    "detection_limits": sentences (detection_limits.h)}
///
/// where "effect" of the first model is "", and "question" is what an experiment would answer. Throws
/// InputError. Some seconds.
nlohmann::json identify(const std::vector<std::string>& logs, const std::string& name,
                        const CommissionFolder& folder, Progress& progress);

struct PlannedMotion {
  SetPoints motion;
  double peak_force_N = 0.0;
};

/// The experiment that tells these effects apart, within the room of the axis and what its logs have reached;
/// nothing where none would say more than the logs do. Some seconds.
std::optional<PlannedMotion> planned_motion(const std::vector<std::string>& logs,
                                            const std::vector<std::string>& effects, const AxisLimits& room,
                                            double seconds, Progress& progress);

}  // namespace slipstack::workbench
