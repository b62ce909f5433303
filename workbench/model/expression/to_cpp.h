// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/model/expression/definition.h"
#include "workbench/model/expression/linearity.h"

namespace slipstack::workbench {

/// The definition as an effect header by the contract of firmware/effects/effect.h: a class for the catalogue
/// whose basis uses the functions of approx.h and no C library. Throws DefinitionError where the expression
/// uses a function that the controller does not have.
std::string to_effect_header(const Definition& definition, const ParameterRoles& roles);

/// The expression alone as C++, in terms of `Real`, approx:: and its names. Precedence and associativity are
/// those of muparser.
std::string to_cpp(const Definition& definition);

}  // namespace slipstack::workbench
