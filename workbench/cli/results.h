// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "workbench/cli/commands.h"
#include "workbench/identify/fit.h"
#include "workbench/model/model.h"
#include "workbench/report/report_data.h"

namespace slipstack::workbench {

// What the commands' results have in common: text, JSON, report.

/// A force in N for people.
std::string newtons(double value_N);
/// A share of one, in per cent.
std::string share(double value);

/// With a capital and a full stop.
std::string sentence(std::string words);

/// Text for machines, one trailing newline; names that are not UTF-8 made so.
std::string json_text(const nlohmann::json& value);

/// The head of every report.
nlohmann::json report_base(const Options& options, const std::string& command);

/// The figures that the report shows on top.
nlohmann::json figures_json(const FittedModel& fitted, double floor_N);

/// A fit, for machines.
nlohmann::json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N);

/// Measured force and the model's, at the rows.
ForceRows rows_of(const FittedModel& fitted);

/// The model file of a fit, with the hysteresis reduced to the controller's elements.
Model model_of(const Options& options, const Measurement& measurement, const FittedModel& fitted,
               double floor_N);
std::string hash_text(const Model& model);

/// Where the model went, and what the reduction to the controller costs.
std::string model_lines(const std::string& path, const Model& model);

}  // namespace slipstack::workbench
