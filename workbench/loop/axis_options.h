// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/log/draw.h"
#include "sim_host/plant/effects/effect_id.h"

namespace slipstack::workbench {

/// The effects of the axis of `loop` and of `node` beside mass and hysteresis: names with commas, `none` for
/// nothing. Throws UsageError where a name is no effect of the simulated axis.
std::vector<sim::EffectId> effects_of(const std::string& list);

/// The same, or for `random` one effect, drawn by the seed.
std::vector<sim::EffectId> effects_by_seed(const std::string& list, std::uint64_t seed);

/// Their names with commas, or `none`.
std::string names_of(const std::vector<sim::EffectId>& effects);

/// The set-up that an axis is drawn from: pick_and_place or random. Throws UsageError for another name.
sim::Setup setup_named(const std::string& name);

/// The seed of a draw. Throws UsageError where it is negative.
std::uint64_t seed_of(std::int64_t seed);

/// Throws UsageError unless `strength` is a permitted multiple of the noise floor.
void check_strength(double strength);

}  // namespace slipstack::workbench
