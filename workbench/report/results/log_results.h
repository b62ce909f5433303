// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/report/pictures.h"

// The error of a model on each of several logs.
namespace slipstack::workbench {

/// The error of a model on one of several logs.
struct LogResult : LogErrors {
  std::string path;
  std::size_t samples = 0;
  double noise_floor_N = 0.0;
  double force_noise_N = 0.0;
};

/// One for each log. `fitted` may be null; there are then no held-out errors. `whole`: the errors of the
/// whole logs where the measurement is an excerpt, else empty.
std::vector<LogResult> log_results(const Measurement& measurement, const ForceRows& rows,
                                   const FittedModel* fitted, const std::vector<LogErrors>& whole);

/// One for each log, noise floors included; empty for a single log.
std::vector<LogResult> log_results(const Measurement& measurement, const FittedModel& fitted);

nlohmann::json logs_json(const std::vector<LogResult>& logs);

/// The table of the terminal; empty for a single log.
std::string log_table(const std::vector<LogResult>& logs);

/// Adds the table to a report; nothing for a single log.
void add_logs(nlohmann::json& report, const std::vector<LogResult>& logs);

}  // namespace slipstack::workbench
