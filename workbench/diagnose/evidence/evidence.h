// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The effect's evidence with the fitted values filled in, in plain words.
std::string evidence_of(const Term& fitted);

}  // namespace slipstack::workbench
