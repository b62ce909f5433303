// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "workbench/plan/next_experiment.h"

namespace slipstack::workbench {

/// Verdict and errors in one sentence, and the reason for the verdict.
struct Headline {
  std::string line;
  std::string detail;
};
Headline headline_of(const nlohmann::json& result, const EffectName& name);

}  // namespace slipstack::workbench
