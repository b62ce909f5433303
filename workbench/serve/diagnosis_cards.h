// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/long_logs/log_search.h"

namespace slipstack::workbench {

/// The diagnosis of the logs against a model file, as `slipstack diagnose --stepwise --json` writes it, and
/// for the page's cards besides: of each candidate `formula`, `look` (what its residual looks like), `term`
/// (shapes and gains) and `expected` (what it would leave over each coordinate, report/pictures.h); the
/// headline; the command line that does the same.
nlohmann::json diagnosis_cards(const LogRequest& request, const std::string& model,
                               const std::vector<std::string>& user_effects, Progress& progress);

/// The term that a diagnosis fitted for one of its candidates. Throws UsageError where there is none.
Term term_of_card(const Measurement& measurement, const nlohmann::json& diagnosis, const std::string& effect);

}  // namespace slipstack::workbench
