// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/model/expression/definition.h"
#include "workbench/model/expression/linearity.h"

namespace slipstack::workbench {

/// The definition as an effect header after the contract of firmware/effects/effect.h: a class that the
/// catalogue takes with one line, its basis made of the functions of approx.h, no libm. Throws
/// DefinitionError where the expression uses a function that the controller does not have.
std::string to_effect_header(const Definition& definition, const ParameterRoles& roles);

/// The expression alone, in terms of `Real`, approx:: and the names that it uses. Precedence and
/// associativity as muparser reads them.
std::string to_cpp(const Definition& definition);

}  // namespace slipstack::workbench
