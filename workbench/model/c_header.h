// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/model/model.h"

namespace slipstack::workbench {

/// What the controller runs of a model, as a C header of constants: one for each parameter, or an array where
/// a group has several, named SLIPSTACK_<EFFECT>_<PARAMETER>, with units in the comments and the hash that
/// the controller reports. It compiles as C99 and as C++.
std::string to_c_header(const Model& model);

}  // namespace slipstack::workbench
