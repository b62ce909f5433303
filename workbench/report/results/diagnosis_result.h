// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/measurement/plausibility.h"
#include "workbench/model/model.h"
#include "workbench/plan/next_experiment.h"
#include "workbench/report/results/log_results.h"

// The result of `diagnose`, made once; the JSON, the text of the terminal and the page show it.
namespace slipstack::workbench {

/// What the command line asked for.
struct DiagnosisRequest {
  std::string command_line;
  std::string log;  ///< names of the logs, separated by ", "
  PlanBasis basis;
  bool stepwise = false;
};

struct DiagnosisResult {
  nlohmann::json json;          ///< as `diagnose --stepwise --json` writes it (docs/json.md)
  Terms fitted;                 ///< with standard errors: of the baseline, and of all that is named
  std::vector<LogResult> logs;  ///< of the final explanation; empty for a single log
  std::optional<NextExperiment> next;
  std::vector<InputWarning> warnings;
};

DiagnosisResult diagnosis_result(const DiagnosisRequest& request, const Measurement& measurement,
                                 const Diagnosis& diagnosis);

/// What `--json` writes: the steps only where they were asked for.
nlohmann::json published_json(const DiagnosisRequest& request, const DiagnosisResult& result);

/// What the terminal shows; effects are called by their ids.
std::string diagnosis_text(const DiagnosisRequest& request, const Measurement& measurement,
                           const DiagnosisResult& result);

/// The data of the report (html/report_page.h); effects are called by their titles. `diagnosis` gives what is
/// drawn. `model`: the baseline's file, whose history is shown; null where there is none.
nlohmann::json diagnosis_page(const DiagnosisRequest& request, const Measurement& measurement,
                              const Diagnosis& diagnosis, const DiagnosisResult& result, const Model* model);

}  // namespace slipstack::workbench
