// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/model/model.h"

// What is reported of a model file: its history, its hash, and what of it the controller runs.
namespace slipstack::workbench {

/// An entry of the history: the effects that were added, on which log, the held-out error before (0: there
/// was no model) and after. The date is now, or SOURCE_DATE_EPOCH where the environment gives one.
Model::Change change_of(const std::string& log, const std::vector<std::string>& added, double before_N,
                        double after_N, double floor_N);

nlohmann::json history_json(const Model& model);

/// Adds the history to a report as a table; nothing where there is none.
void add_history(nlohmann::json& report, const Model& model);

std::string hash_text(const Model& model);

/// For each user-defined effect whether the controller has it as a table, or why not.
nlohmann::json user_effects_json(const Model& model);

/// Lines of the terminal: where the model was written, what the reduction to the controller costs, and what
/// became of user-defined effects.
std::string model_lines(const std::string& path, const Model& model);

}  // namespace slipstack::workbench
