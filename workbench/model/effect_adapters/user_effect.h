// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

/// Declares a user-defined effect by its definition `text` (expression/definition.h). From then on it is
/// found by its name and fitted like an effect of the catalogue; it lives as long as the program. The same
/// definition again gives the same effect. Throws DefinitionError for a wrong definition, also when the name
/// is that of an effect of the catalogue or was declared with another definition.
///
/// The gains of its expression act as forces in N. Its shapes are searched within their bounds; positions,
/// velocities, accelerations and times without bounds are searched over the range of the log.
const EffectDescription& declare_effect(const std::string& text);

/// The user-defined effect of that name, or nullptr.
const EffectDescription* find_user_effect(std::string_view id);

/// Whether a text is a definition, and not the name of an effect.
bool is_definition(std::string_view text);

}  // namespace slipstack::workbench
