// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "workbench/estimate/terms/terms.h"

// The parameters of a model with their standard errors.
namespace slipstack::workbench {

/// [{effect, title, formula, parameters: [{name, value, standard_error, unit, note}]}]
nlohmann::json parameters_json(const Terms& terms);

/// The table of the terminal, after an empty line. The elements of a hysteresis are one line.
std::string parameter_table(const Terms& terms);

}  // namespace slipstack::workbench
