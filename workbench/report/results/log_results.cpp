// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/log_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/base/text.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

/// Errors at the rows of one log.
LogErrors errors_at_rows(const Measurement& measurement, std::size_t log, const ForceRows& rows,
                         const FittedModel* fitted) {
  const auto [first, count] = measurement.rows_of_log(log);
  const Eigen::VectorXd weights = measurement.row_weights().segment(first, count);
  const Eigen::VectorXd usable = measurement.row_usable().segment(first, count);
  const Eigen::VectorXd residual_N = rows.residual_N().segment(first, count).cwiseProduct(usable);
  LogErrors errors;
  errors.rmse_N = std::sqrt(weights.dot(residual_N.cwiseAbs2()) / weights.sum());
  errors.relative_error =
      residual_N.norm() / std::max(rows.measured_N.segment(first, count).cwiseProduct(usable).norm(), 1e-300);
  if (fitted == nullptr) return errors;
  const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
  double sum = 0.0;
  for (int block = part.first_block; block < part.first_block + part.block_count; ++block) {
    sum += fitted->block_squared_error[static_cast<std::size_t>(block)];
  }
  errors.holdout_rmse_N = std::sqrt(sum / weights.sum());
  return errors;
}

}  // namespace

std::vector<LogResult> log_results(const Measurement& measurement, const ForceRows& rows,
                                   const FittedModel* fitted, const std::vector<LogErrors>& whole) {
  std::vector<LogResult> results;
  results.reserve(measurement.log_count());
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
    const LogErrors errors = whole.empty() ? errors_at_rows(measurement, log, rows, fitted) : whole[log];
    results.push_back({errors, part.path, measurement.log_sample_count(log),
                       measurement.noise_floor_of_log_N(log), part.force_noise_N});
  }
  return results;
}

std::vector<LogResult> log_results(const Measurement& measurement, const FittedModel& fitted) {
  if (measurement.log_count() == 1) return {};
  return log_results(measurement, rows_of(fitted), &fitted, fitted.log_errors);
}

json logs_json(const std::vector<LogResult>& logs) {
  json list = json::array();
  for (const LogResult& one : logs) {
    json entry{{"log", one.path},
               {"samples", one.samples},
               {"rmse_N", number_json(one.rmse_N)},
               {"noise_floor_N", number_json(one.noise_floor_N)},
               {"force_noise_N", number_json(one.force_noise_N)},
               {"relative_error", number_json(one.relative_error)}};
    if (one.holdout_rmse_N > 0.0) entry["holdout_rmse_N"] = one.holdout_rmse_N;
    list.push_back(std::move(entry));
  }
  return list;
}

void add_logs(json& report, const std::vector<LogResult>& logs) {
  if (logs.size() < 2) return;
  const bool held_out = logs.front().holdout_rmse_N > 0.0;
  json rows = json::array();
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const LogResult& one = logs[i];
    rows.push_back({fmt::format("{}", i + 1), printable(one.path), fmt::format("{}", one.samples),
                    newtons(held_out ? one.holdout_rmse_N : one.rmse_N), newtons(one.noise_floor_N),
                    share(one.relative_error)});
  }
  const auto column = [](const std::string& heading, bool number) {
    return json{{"heading", heading}, {"unit", ""}, {"number", number}};
  };
  report["tables"].push_back(
      {{"title", "The logs one by one"},
       {"columns",
        {column("", true), column("Log", false), column("Samples", true),
         column(held_out ? "Held-out error" : "Error", true), column("Noise floor", true),
         column(fmt::format("Relative {} error", force_word()), true)}},
       {"rows", rows}});
}

std::string log_table(const std::vector<LogResult>& logs) {
  if (logs.size() < 2) return "";
  const bool held_out = logs.front().holdout_rmse_N > 0.0;
  std::string text =
      fmt::format("\n{:<32} {:>9} {:>14} {:>14} {:>9}\n", "log", "samples",
                  held_out ? "held-out error" : "error", "noise floor", fmt::format("of {}", force_word()));
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const LogResult& one = logs[i];
    text +=
        fmt::format("{:<32} {:>9} {:>14} {:>14} {:>9}\n", fmt::format("{} {}", i + 1, printable(one.path)),
                    one.samples, newtons(held_out ? one.holdout_rmse_N : one.rmse_N),
                    newtons(one.noise_floor_N), share(one.relative_error));
  }
  return text;
}

}  // namespace slipstack::workbench
