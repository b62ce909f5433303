// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {

/// The parameters that a person can set, with their bounds: [{effect, title, kind, index, name, value, lower,
/// upper, standard_error, unit}]. `kind` is shape, gain, or factor: all gains of a group of several (the
/// elements of a hysteresis, the values of a map) at once, times the value. Given masses are not among them.
nlohmann::json adjustable(const Terms& terms);

/// Sets parameters by hand: `changes` as [{effect, kind, index, value}], each limited to its bounds. Throws
/// UsageError for what is none.
void apply_changes(Terms& terms, const nlohmann::json& changes);

/// A model with parameters set by hand, as a version of its own: its error on the logs, nothing fitted.
Model with_changes(LogSearch& logs, const std::string& log, const Model& model, const nlohmann::json& changes,
                   Progress& progress);

}  // namespace slipstack::workbench
