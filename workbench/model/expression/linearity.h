// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/model/expression/definition.h"

namespace slipstack::workbench {

/// How the parameters of a definition enter its expression; indices into Definition::parameters.
struct ParameterRoles {
  std::vector<std::size_t> gains;   ///< the expression is a sum of gain times something, jointly
  std::vector<std::size_t> shapes;  ///< all others: searched
};

/// Whether shapes of this unit need no bounds, because the log gives their range: m, m/s, m/s2, s.
bool range_from_log(const std::string& unit);

/// Finds the parameters that are gains by evaluating the expression at some 200 random instants and parameter
/// values (fixed seed). Throws DefinitionError where no parameter enters linearly, where a term of the
/// expression has no gain, where a parameter only scales a gain, or where a shape needs bounds and has none.
ParameterRoles roles_of(const Definition& definition);

}  // namespace slipstack::workbench
