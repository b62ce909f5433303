// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

/// Ids of the effects in the model that is there before anything is known, and the same as --effects takes
/// them.
const std::vector<std::string>& default_baseline();
std::string default_baseline_list();

/// The description of `id`, of the catalogue or declared by the user (user_effect.h), or nullptr.
const EffectDescription* find_effect(std::string_view id);

/// The same; throws UsageError with the known ids where there is none.
const EffectDescription& effect_named(std::string_view id);

/// All ids of the catalogue, separated by commas: for messages.
std::string known_effects();

/// Ids of a comma-separated list, of the catalogue or declared, each known and named once; else UsageError.
std::vector<std::string> parse_effects(const std::string& list);

/// Declares user-defined effects by their definitions, in order. Throws UsageError for a text that is no
/// definition or is given twice, and DefinitionError for a wrong definition.
std::vector<const EffectDescription*> declare_effects(const std::vector<std::string>& definitions);

}  // namespace slipstack::workbench
