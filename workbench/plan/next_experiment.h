// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// The experiment that would answer what a diagnosis leaves open.
struct NextExperiment {
  enum class Purpose {
    separate,  ///< two effects that this log cannot tell apart
    confirm,   ///< the first candidate
    rule_out   ///< effects that this log cannot show
  };
  Purpose purpose;
  std::vector<std::string> effects;      ///< ids; of `separate` two
  double angle_deg = 0.0;                ///< of `separate`: between the forces of the two
  std::vector<std::string> beside = {};  ///< ids of the other effects of the model that explains the log
};

/// Separates a pair that this log cannot tell apart, one with the first candidate before the others; else
/// confirms the first candidate, where an effect is missing; else rules out what this log cannot show. None
/// where no experiment can be planned for any of these.
std::optional<NextExperiment> next_experiment(const Diagnosis& diagnosis);

/// How an effect is called in a text, from its id.
using EffectName = std::function<std::string(const std::string& id)>;

/// Why the experiment is proposed: a sentence without its capital and its full stop.
std::string reason_text(const NextExperiment& next, const EffectName& name);

/// The logs and the baseline of the diagnosis, as they were typed.
struct PlanBasis {
  std::vector<std::string> logs;
  std::string model;  ///< file of the baseline; may be empty
};

/// `slipstack experiment plan ...` as it is typed in a shell: beside all that the log is explained by, since
/// what a baseline leaves hides an effect; beside the model of a file as it is.
std::string plan_command(const NextExperiment& next, const PlanBasis& basis);

}  // namespace slipstack::workbench
