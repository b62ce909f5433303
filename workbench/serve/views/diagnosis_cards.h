// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/nonlinear/trial.h"
#include "workbench/long_logs/log_search.h"

namespace slipstack::workbench {

/// What is known of an effect while others are still tried: effect, title, formula, evidence and, to first
/// order in its gains, holdout_rmse_N and error_reduction.
nlohmann::json tried_card(const Trial& trial, double baseline_N);

/// The diagnosis of the logs against a model file, as `slipstack diagnose --stepwise --json` writes it, and
/// for the page's cards besides: of each candidate `formula`, `look` (what its residual looks like), `term`
/// (shapes and gains) and `expected` (what it would leave over each coordinate, report/pictures.h); the
/// headline; the command line that does the same. `tried` gets a tried_card() for each effect as soon as it
/// is known, from several threads.
nlohmann::json diagnosis_cards(LogSearch& logs, const std::string& model,
                               const std::vector<std::string>& user_effects, Progress& progress,
                               const std::function<void(nlohmann::json)>& tried);

/// The term that a diagnosis fitted for one of its candidates; nothing where there is none.
std::optional<Term> term_of_card(const Measurement& measurement, const nlohmann::json& diagnosis,
                                 const std::string& effect);

}  // namespace slipstack::workbench
