// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The evidence text of the effect with the fitted values filled in.
std::string evidence_of(const Term& fitted);

}  // namespace slipstack::workbench
