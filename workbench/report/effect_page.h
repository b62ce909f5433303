// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

/// The description of an effect as Markdown: formula, source, parameters with units and bounds, what its
/// residual looks like, cause, and the experiment that confirms it. It is made from the effect's own header
/// and so agrees with the code.
std::string effect_description(const EffectDescription& effect);

/// The same as a file of docs/effects, which says where it comes from.
std::string effect_page(const EffectDescription& effect);

/// Id and title of every effect, a line each.
std::string effect_lines(const std::string& indent);

/// The page of docs/effects that lists all effects, with links.
std::string effect_index();

}  // namespace slipstack::workbench
