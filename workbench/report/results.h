// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/model.h"
#include "workbench/report/report_data.h"

namespace slipstack::workbench {

// What the commands' results have in common: text, JSON, report.

/// A force in N for people.
std::string newtons(double value_N);
/// The 95 % interval of a model's held-out error by block bootstrap, for people and for machines.
std::string interval_text(const FittedModel& fitted);
nlohmann::json interval_json(const FittedModel& fitted);
/// A share of one, in per cent.
std::string share(double value);

/// With a capital and a full stop.
std::string sentence(std::string words);

/// Text for machines, one trailing newline; names that are not UTF-8 made so.
std::string json_text(const nlohmann::json& value);

/// The head of every report.
nlohmann::json report_base(const std::string& command_line, const std::string& log,
                           const std::string& command);

/// The figures that the report shows on top.
nlohmann::json figures_json(const FittedModel& fitted, double floor_N);

/// Where the noise floor comes from: one line, and the same for machines.
std::string noise_line(const Measurement& measurement);
/// In what of long logs `what` was done; empty where in all.
std::string excerpt_line(const Measurement& measurement, std::string_view what);
nlohmann::json noise_json(const Measurement& measurement);

/// What was repaired in the logs and left out of them: a line each, empty for clean logs.
std::string repair_lines(const Measurement& measurement);
nlohmann::json repairs_json(const Measurement& measurement);

/// A fit, for machines.
nlohmann::json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N);

/// What a model leaves of one log among several.
struct LogResult : LogErrors {
  std::string path;
  std::size_t samples = 0;
  double noise_floor_N = 0.0;
  double force_noise_N = 0.0;
};
/// One for each log. `fitted` may be nullptr; its terms then are not given either. `whole` are the errors of
/// the whole logs where the measurement is an excerpt.
std::vector<LogResult> log_results(const Measurement& measurement, const ForceRows& rows,
                                   const std::vector<double>& floors_N, const FittedModel* fitted,
                                   const std::vector<LogErrors>& whole);
std::vector<LogResult> log_results(const Measurement& measurement, const FittedModel& fitted);
nlohmann::json logs_json(const std::vector<LogResult>& logs);

/// One change of a model, now: the effects that were added, on which log, the error before (0: nothing was
/// there) and after. The date is SOURCE_DATE_EPOCH's where the environment gives one.
Model::Change change_of(const std::string& log, const std::vector<std::string>& added, double before_N,
                        double after_N, double floor_N);

/// The history of a model for machines, and as a table of the report.
nlohmann::json history_json(const Model& model);
void add_history(nlohmann::json& report, const Model& model);
/// A table of the logs into a report; nothing for a single one.
void add_logs(nlohmann::json& report, const std::vector<LogResult>& logs);

/// Measured force and the model's, at the rows.
ForceRows rows_of(const FittedModel& fitted);

/// `fitted` with the hysteresis reduced to the controller's elements.
FittedModel on_controller(const Measurement& measurement, const FittedModel& fitted);

/// The model file of a fit and of what on_controller() made of it.
Model model_of(const std::string& log, const Measurement& measurement, const FittedModel& fitted,
               const FittedModel& reduced, double floor_N);

/// Puts a table in the place of a user's own effect in what the controller runs, which evaluates no
/// expressions; leaves out those that have none, or come after the first. The target's error then tells what
/// that costs.
void tabulate_user_effects(const Measurement& measurement, Model& model, double floor_N);
/// What became of them, a line each; and for machines.
std::string user_effect_lines(const Model& model);
nlohmann::json user_effects_json(const Model& model);

std::string hash_text(const Model& model);

/// Where the model went, and what the reduction to the controller costs.
std::string model_lines(const std::string& path, const Model& model);

}  // namespace slipstack::workbench
