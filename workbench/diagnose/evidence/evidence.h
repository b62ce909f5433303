// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The evidence text of the effect with the fitted values filled in: of a map its largest value over the
/// travel that the log has shown. `model`: all terms with which it was fitted, which may bound its gains.
std::string evidence_of(const Term& fitted, const Terms& model);

}  // namespace slipstack::workbench
