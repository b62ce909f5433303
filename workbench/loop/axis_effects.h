// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim_host/effects/effect_id.h"

namespace slipstack::workbench {

/// The effects of the axis of `loop` and of `node` beside mass and hysteresis: names with commas, `none` for
/// nothing. Throws UsageError where a name is no effect of the simulated axis.
std::vector<sim::EffectId> effects_of(const std::string& list);

/// Throws UsageError unless `strength` is a permitted multiple of the noise floor.
void check_strength(double strength);

}  // namespace slipstack::workbench
