// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

// The parameters of a model with their standard errors.
namespace slipstack::workbench {

/// [{effect, title, formula, parameters: [{name, value, standard_error, unit, note}]}]
nlohmann::json parameters_json(const Terms& terms);

/// Friction in steady motion each way where an effect makes it differ, else null: {forward: {dry_N,
/// dry_standard_error_N, slope, slope_standard_error}, backward: {...}, slope_unit}.
nlohmann::json friction_each_way_json(const FittedModel& fitted);
/// The same as a line of the terminal, with two standard errors to either side; else empty.
std::string friction_each_way_line(const FittedModel& fitted);

/// The same as a table of the report.
void add_friction_each_way(nlohmann::json& report, const FittedModel& fitted);

/// The values of the effects `ids` of a model with two standard errors to either side, for a line of the
/// terminal: "mass 95.39 +- 0.37 kg, level of 4 elements 20.62 +- 0.24 N". Of a map or of harmonics no single
/// value tells anything; they are left out, as are shapes.
std::string values_text(const Terms& terms, const std::vector<std::string>& ids);

/// The table of the terminal, after an empty line. The elements of a hysteresis are one line.
std::string parameter_table(const Terms& terms);

}  // namespace slipstack::workbench
