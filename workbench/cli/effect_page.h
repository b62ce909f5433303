// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/model/effects/effect_catalogue.h"

namespace slipstack::workbench {

/// The reference page of an effect, as Markdown: formula, source, parameters with units and bounds, what its
/// residual looks like, cause, the experiment that confirms it. Made of the effect's own header, so it cannot
/// be stale.
std::string effect_page(const EffectDescription& effect);

/// Id and title of every effect, a line each.
std::string effect_lines(const std::string& indent);

/// The page that lists all, with links.
std::string effect_index();

}  // namespace slipstack::workbench
