// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/model/expression/definition.h"

namespace slipstack::workbench {

/// How the parameters of a definition enter its expression; indices into Definition::parameters.
struct ParameterRoles {
  std::vector<std::size_t> gains;   ///< the expression is a sum of gain times something, jointly
  std::vector<std::size_t> shapes;  ///< the others: searched
};

/// Units of shapes that need no bounds, because a log tells their range: m, m/s, m/s2, s.
bool range_from_log(const std::string& unit);

/// Which parameters are gains, found by evaluation at some 200 random instants and parameters (fixed seed).
/// Throws DefinitionError where none enters linearly, where a part of the expression has no gain, where a
/// parameter only scales a gain, or where a shape needs bounds and has none.
ParameterRoles roles_of(const Definition& definition);

}  // namespace slipstack::workbench
