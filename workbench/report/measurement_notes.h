// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/measurement/plausibility.h"

// How a log was read and prepared. The lines are those of the terminal, each with a newline.
namespace slipstack::workbench {

/// How large the noise of the force is, and how it was estimated.
std::string noise_line(const Measurement& measurement);
nlohmann::json noise_json(const Measurement& measurement);

/// How many samples of long logs `what` was done on; empty where it was done on all.
std::string excerpt_line(const Measurement& measurement, std::string_view what);

/// Faults of the recorder that were repaired in the logs, or left out: a line each, empty for clean logs.
std::string repair_lines(const Measurement& measurement);
nlohmann::json repairs_json(const Measurement& measurement);

/// The notes of the report: filter, burn-in, noise, blocks, and what the reader of the log noted.
nlohmann::json method_notes(const Measurement& measurement);

/// What of the input contradicts physics: lines for the terminal, before all others, for the page's verdict,
/// and `input_warnings` of the JSON, a list of `kind` and `what`.
std::string warning_lines(const std::vector<InputWarning>& warnings);
std::string warning_sentences(const std::vector<InputWarning>& warnings);
nlohmann::json warnings_json(const std::vector<InputWarning>& warnings);

}  // namespace slipstack::workbench
