// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/diagnose/diagnose.h"
#include "workbench/report/results.h"

namespace slipstack::workbench {

// Aligned tables for a terminal, each after an empty line.
std::string parameter_table(const Terms& terms);
std::string candidate_table(const Diagnosis& diagnosis);
/// What is left of each log; empty for a single one.
std::string log_table(const std::vector<LogResult>& logs);
std::string step_table(const Diagnosis& diagnosis);
/// The usual cause and the experiment that confirms.
std::string advice(const Candidate& candidate);

}  // namespace slipstack::workbench
