// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim_host/effects/effect_id.h"

namespace slipstack::workbench {

/// What the axis of `loop` and of `node` has beside mass and hysteresis: names with commas, `none` for
/// nothing. Throws UsageError where a name is no effect that an axis can be given.
std::vector<sim::EffectId> effects_of(const std::string& list);

/// Throws UsageError unless `strength` is a multiple of the noise floor that an effect can be given.
void check_strength(double strength);

}  // namespace slipstack::workbench
